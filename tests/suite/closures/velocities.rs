//! Velocities at the start of models whose loops are closed: kept where the joints allow them, refused otherwise.

use super::linkage_of;
use crate::support::closures::{start, *};
use crate::support::program::{assert_close, check, refusal};
use nalgebra::{DMatrix, DVector};

/// Two bodies, the second at the end of an arm on a ball joint at the first.
fn linked(closure: &str, a: &str, b: &str) -> String {
    [
        "[nodes]\na = [0, 0, 0]\nb = [1, 0, 0]\n",
        &body("a"),
        &body("b"),
        &joint("ball", "spherical", "a", ""),
        &arm("arm", "ball", [1.0, 0.0, 0.0]),
        &joint("weld", "weld", "arm", &format!("child = \"b\"\n{closure}")),
        &format!("[[initial]]\nnode = \"a\"\n{a}\n[[initial]]\nnode = \"b\"\n{b}\n"),
        RUN,
    ]
    .concat()
}

#[test]
fn velocities_of_bodies_are_kept_where_the_loop_allows_them() {
    for closure in &CLOSURES[1..] {
        let text = linked(closure, "velocity = [0, 1, 0]", "velocity = [0, 3, 0]");
        let job = started(&text);
        // The arm between them is 1 long: ω = (3 − 1)/1 about the third axis.
        let [a, b] = ["a", "b"].map(|n| job.context.node_state(job.context.find(n).unwrap()));
        for (found, wanted) in [
            (a.velocity, [0.0, 1.0, 0.0]),
            (b.velocity, [0.0, 3.0, 0.0]),
            (b.omega, [0.0, 0.0, 2.0]),
        ] {
            let off = (found - nalgebra::Vector3::from(wanted)).amax();
            assert!(off < 1e-13, "{closure}: {found} for {wanted:?}");
        }
        // Along the arm they are equally fast, and b turns as the arm does: the second entry is at
        // fault.
        let still = "velocity = [0, 3, 0]\nangular_velocity = [0, 0, 0]";
        for b in ["velocity = [5, 1, 0]", still] {
            let text = linked(closure, "velocity = [0, 1, 0]", b);
            check(&text, "[[initial]]", "joints at weld", "rate");
            let position = refusal(&text).span.unwrap().start;
            assert_eq!(Some(position), text.rfind("[[initial]]"));
        }
    }
}

/// A slider-crank of 0.2 and 0.6 at its dead centre, whose connecting rod is a line that turns by −10/3 rad/s for 10 of the
/// crank, beside a part that is prescribed: the joints allow the entry of the line, so it is kept.
#[test]
fn a_line_starts_as_its_entry_says_beside_other_parts() {
    let text =
        |closure: &str, crank: &str, spin: f64| {
            let rail = "[[supports]]\nnode = \"aside\"\nprescribed = { x = { constant = 0 } }\n";
            [
            "[sections.main]\nstiffness = { EA = 1e6, GA = [1e6, 1e6], GJ = 10, EI = [10, 10] }\n",
            "mass = { A_rho = 1, J = [2e-4, 1e-4, 1e-4] }\n",
            &GROUND.replace("[nodes]\n", "[nodes]\nend = [0.8, 0, 0]\naside = [5, 0, 0]\n"),
            &hinge("crank", "ground", crank),
            &arm("pin", "crank", [0.2, 0.0, 0.0]),
            &hinge("big", "pin", ""),
            &beam_line("rod", ["big", "end"], 2, "main"),
            &arm("rail", "ground", [0.8, 0.0, 0.0]),
            &joint("slider", "prismatic", "rail", "axis = [1, 0, 0]"),
            &hinge("wrist", "slider", &format!("child = \"end\"\n{closure}")),
            &["crank", "slider", "end", "aside"].map(body).concat(),
            rail,
            "[[initial]]\nline = \"rod\"\nabout = [0.8, 0, 0]\n",
            &format!("angular_velocity = [0, 0, {spin:?}]\n"),
            RUN,
        ]
        .concat()
        };
    for closure in CLOSURES {
        for crank in ["rate = 10", ""] {
            let job = started(&text(closure, crank, -10.0 / 3.0));
            let spin = |name: &str| {
                let node = job.context.find(name).unwrap();
                job.context.node_state(node).omega.z
            };
            assert_close(spin("crank"), 10.0, 1e-9, closure);
            assert_close(spin("end"), -10.0 / 3.0, 1e-9, closure);
        }
    }
}

#[test]
fn a_rate_in_a_loop_that_is_locked_is_told_so() {
    for closure in &CLOSURES[1..] {
        let text = linkage_of(["rate = 2.0", "", ""], closure);
        let tilted = "parent = \"foot\"\naxis = [0, 1e-5, 1]";
        let text = text.replace("parent = \"foot\"\naxis = [0, 0, 1]", tilted);
        assert!(text.contains(tilted));
        let message = "the initial rate of A is not possible: its loop leaves it no freedom";
        check(&text, "2.0", message, "axes and positions");
    }
}

/// One rate is given in a loop of two freedoms: the rates of all its joints are the smallest, whatever closes it.
#[test]
fn a_rate_in_a_loop_of_two_freedoms_moves_all_joints_as_little_as_possible() {
    // The tips stay together, and C turns as the two do: of B, E, D and C, and of A with a rate of 1.
    let gap = [
        [-2.0, -1.0, 0.0, 0.0],
        [0.3, -0.5, -1.3, 0.0],
        [1.0, 1.0, -1.0, 1.0],
    ];
    let gap = DMatrix::from_fn(3, 4, |i, j| gap[i][j]);
    let of_a = DVector::from_vec(vec![-2.0, 1.3, 1.0]);
    let smallest = gap.svd(true, true).solve(&-of_a, 1e-12).unwrap();
    let names = ["B", "E", "D", "C"];
    for closure in CLOSURES {
        let text = five_bar(["rate = 1", "", closure]) + &body("B");
        let (found, _) = start(&(text + &["A", "B", "E", "D", "C"].map(angle).concat()));
        let rate = |name: &str| found[&format!("{name} angle")][1];
        assert_close(rate("A"), 1.0, 1e-9, closure);
        for (name, expected) in names.iter().zip(&smallest) {
            assert_close(
                rate(name),
                *expected,
                1e-9,
                format_args!("{closure}: {name}"),
            );
        }
    }
}
