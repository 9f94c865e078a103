//! Loops at the limits of what they can be: without coordinates, locked, tiny and huge, driven fast
//! or too far, started with words that do not fit.

use crate::support::closures::*;
use crate::support::prelude::*;
use crate::support::program::*;

const RUN: &str = "[analysis.dynamic]\nto = 1\nstep = 0.01\nscheme = { newmark = [0.25, 0.5] }\n";

#[test]
fn a_loop_without_coordinates_is_redundant_or_does_not_fit() {
    let base = [
        GROUND,
        RUN,
        &hinge("A", "ground", "rate = 2.0"),
        &arm("x", "A", [1.0, 0.0, 0.0]),
    ];
    let base = base.concat() + &body("A") + &angle("A");
    let second = |position: [f64; 3]| base.clone() + &arm("y", "A", position) + "child = \"x\"\n";
    let (said, rows) = rows("limits-nothing", &second([1.0, 0.0, 0.0]));
    assert_says(&said, &["y: nothing can move", "redundant"]);
    assert_close(number(rows.last().unwrap(), "A"), 2.0, 1e-12, "A");
    let text = second([1.0, 0.25, 0.0]);
    let message = "joint y and its child x are 2.500e-1 apart";
    check(&text, "\"y\"", message, "");
    // The program's two commands agree on it.
    for (name, child) in [("limits-own", "A"), ("limits-own-weld", "ground")] {
        let text = base.clone() + &joint("w", "weld", child, &format!("child = \"{child}\""));
        let path = write(&directory(name), &text);
        for word in ["run", "check"] {
            let said = ended(&command(word, &[&path]), 2);
            assert!(!said.contains("panicked"), "{said}");
            assert!(said.contains("joint w: its child"), "{said}");
        }
    }
}

/// The four-bar linkage as a model, with words for crank, coupler and rocker.
fn model(words: [&str; 3]) -> String {
    [GROUND, RUN, &four_bar(words, "")].concat()
}

/// Two hinges on one axis.
fn twice(more: &str) -> String {
    [
        GROUND,
        RUN,
        &hinge("A", "ground", ""),
        &hinge("A2", "ground", "child = \"A\""),
        &body("A"),
        &angle("A"),
        more,
    ]
    .concat()
}

#[test]
fn velocities_of_the_whole_set_the_rates_of_loops() {
    let initial = "[[initial]]\nangular_velocity = [0, 0, 2]\n";
    let rows = recorded("limits-initial", &twice(initial));
    assert_close(number(rows.last().unwrap(), "A"), 2.0, 1e-12, "A");
    // A four-bar linkage does not turn as a whole.
    let text = model(["", "", ""]) + initial;
    check(&text, "[[initial]]", "joints at C", "rate");
    // All of it, flying.
    let text = text.replace(&fixed("ground"), &body("ground"));
    let rates = assemble_text("model.toml", &text).unwrap().start.v;
    let square = rates.iter().map(|v| v * v).sum();
    assert_close(square, 4.0, 1e-12, format_args!("{:?}", rates));
}

#[test]
fn velocities_of_the_whole_set_the_rates_of_joints_or_are_refused() {
    let second = joint("j", "prismatic", "i", "axis = [0.6, 0.8, 0]");
    let model = |first: &str, initial: &str| {
        let first = joint("i", first, "ground", "axis = [1, 0, 0]");
        let initial = format!("[[initial]]\n{initial}\n");
        // What is fixed to the ground stays.
        let fixed = arm("o", "ground", [1.0, 0.0, 0.0]) + &body("o");
        GROUND.to_owned() + RUN + &first + &second + &body("j") + &fixed + &initial
    };
    // Both slides together: e2 = −0.75 e1 + 1.25 (0.6, 0.8, 0).
    let slides = assemble_text("slides", &model("prismatic", "velocity = [0, 1, 0]"));
    let v = slides.unwrap().start.v;
    assert!((v[0] + 0.75).abs() < 1e-13 && (v[1] - 1.25).abs() < 1e-13);
    // Neither a hinge about the first axis nor a slide in the plane lets it go up.
    for first in ["prismatic", "revolute"] {
        let text = model(first, "velocity = [0, 0, 1]");
        check(&text, "[[initial]]", "joints at j", "rate");
    }
}

#[test]
fn a_spherical_joint_in_a_loop_takes_an_angular_velocity() {
    // A link between two balls on two hinges: it can spin about the line of its balls, all else at
    // rest.
    let link = |spin: &str| {
        [
            GROUND,
            RUN,
            &hinge("A", "ground", ""),
            &arm("a", "A", [0.0, 1.0, 0.0]),
            &joint("S1", "spherical", "a", ""),
            &arm("s", "S1", [1.5, 1.0, 0.8]),
            &arm("f", "ground", [1.5, 0.0, 0.8]),
            &joint("D", "revolute", "f", "axis = [1, 0, 0]"),
            &arm("d", "D", [1.5, 1.0, 0.8]),
            &joint("S2", "spherical", "s", "child = \"d\""),
            &body("A"),
            &body("D"),
            &body("S1"),
            &format!("[[initial]]\nnode = \"S1\"\nangular_velocity = {spin}\n"),
            "[[probes]]\nname = \"A\"\nquantity = \"joint_rate\"\njoint = \"A\"\n",
            &probe("w", "angular_velocity", "S1"),
        ]
        .concat()
    };
    let rows = recorded("limits-ball", &link("[3.0, 0.0, 1.6]"));
    let found = ["w.x", "w.y", "w.z", "A"].map(|c| number(&rows[0], c));
    for (found, exact) in found.into_iter().zip([3.0, 0.0, 1.6, 0.0]) {
        assert_close(found, exact, 1e-9, "rate");
    }
    let said = refusal(&link("[3.0, 1.0, 0.0]")).to_string();
    assert_says(&said, &["S1", "does not allow"]);
}

#[test]
fn the_independent_end_of_a_gear_takes_rate_and_value() {
    let text = [
        GROUND,
        RUN,
        &hinge("A", "ground", "rate = 1.0\nvalue = 0.3"),
        &hinge("A2", "ground", "child = \"A\""),
        &arm("f", "ground", [1.0, 0.0, 0.0]),
        &hinge("M", "f", ""),
        &body("A"),
        &body("M"),
        "[[gears]]\njoints = [\"A\", \"M\"]\nratio = -2\n",
        &["A", "M"].map(angle).concat(),
    ];
    let rows = recorded("limits-gear", &text.concat());
    let [a, m] = ["A", "M"].map(|c| number(rows.last().unwrap(), c));
    assert_close(a, 1.3, 1e-12, "A");
    assert_close(m, -2.6, 1e-12, "M");
}

#[test]
fn a_fast_drive_stays_on_its_branch() {
    for rate in [20, 70, 85, 145, 155] {
        let drive = format!("prescribed = {{ proportional = {rate} }}");
        let text = model([&drive, "", ""]) + &hinge("X", "ground", "") + &body("X");
        let rows = recorded("limits-fast", &text);
        assert_eq!(rows.len(), 101);
        for row in rows {
            let [a, d] = ["A", "D"].map(|c| number(&row, c));
            let rocker = linkage(a)[1];
            assert!(apart(d, rocker) < 1e-9, "{rate}: {a} {d} {rocker}");
        }
    }
}

#[test]
fn what_cannot_be_reached_names_the_drive() {
    let far = model(["", "", "prescribed = { proportional = 1 }"]);
    let text = far + &hinge("X", "ground", "") + &body("X");
    let said = failed("limits-reach", &text.replace("to = 1\n", "to = 9\n"));
    assert!(said.contains("D angle cannot get there"), "{said}");
    // The same where something stays free: a coupler that spins between its balls.
    let text = [
        GROUND,
        RUN,
        &hinge("A", "ground", "prescribed = { proportional = 1 }"),
        &arm("a", "A", [0.5, 0.0, 0.0]),
        &joint("S1", "spherical", "a", ""),
        &arm("b", "S1", [1.5, 0.4, 0.9]),
        &arm("foot", "ground", [1.5, 0.4, 0.0]),
        &joint("D", "revolute", "foot", "axis = [1, 0, 0]"),
        &arm("d", "D", [1.5, 0.4, 0.9]),
        &joint("S2", "spherical", "b", "child = \"d\""),
        &body("S1"),
        &body("D"),
    ];
    let said = failed("limits-spatial", &text.concat());
    assert!(said.contains("S2: A angle cannot get there"), "{said}");
    // Two drives of one hinge.
    let drive = "prescribed = { proportional = 1 }";
    let text = [GROUND, RUN, &hinge("A", "ground", drive)].concat()
        + &hinge("A2", "ground", &format!("{drive}\nchild = \"A\""))
        + &body("A");
    check(&text, "\"A2\"", "(A angle, A2 angle) are prescribed", "");
}

#[test]
fn energy_stays_while_a_linkage_turns() {
    // Coordinates that change in every turn pump energy into the motion.
    let text = model(["rate = 4.5", "", ""]);
    let text = text.replace("to = 1\n", "to = 60\n");
    let energy = "[[probes]]\nname = \"E\"\nquantity = \"total_energy\"\n";
    let rows = recorded("limits-energy", &(text + energy));
    let energies = rows.iter().map(|r| number(r, "E"));
    let (least, most) = energies.fold((f64::MAX, f64::MIN), |(a, b), e| (a.min(e), b.max(e)));
    assert!(most < 1.2 * least, "{least} to {most}");
}

#[test]
fn ends_that_are_drawn_apart_are_told_of() {
    let text = model(["", "", ""]);
    let text = text.replacen("[1.2, 1.9, 0.0]", "[1.25, 1.9, 0.0]", 1);
    let (said, _) = rows("limits-drawn", &text);
    assert_says(&said, &["C and rocker tip were drawn 5.000e-2 apart"]);
}

/// A crank that is driven to stay where it is drawn: the loop moves no more, and the drive carries it.
#[test]
fn a_crank_held_at_zero_by_its_drive_carries_the_loop() {
    let text = [
        GROUND,
        "[analysis.static]\nsteps = 2\n[[loads]]\ngravity = [-9.81, 0, 0]\ntime = { constant = 1 }\n",
        &four_bar(["prescribed = { constant = 0 }", "", ""], ""),
        &body("rocker tip"),
        &probe("moment", "joint_moment", "A"),
    ];
    let rows = recorded("held-crank", &text.concat());
    // Virtual work: masses of 1 at the crank's tip, (−sin φ, cos φ), and the rocker's, 1.9 high.
    let h = 1e-4;
    let slope = (linkage(h)[1] - linkage(-h)[1]) / (2.0 * h);
    let exact = 9.81 * (-1.0 - 1.9 * slope);
    for row in &rows {
        assert_close(number(row, "moment.z"), exact, 1e-6 * exact.abs(), "moment");
        for angle in ["A", "B", "D"] {
            assert!(number(row, angle).abs() < 1e-12, "{row:?}");
        }
    }
    assert!(!rows.is_empty());
}

#[test]
fn what_is_wrong_with_a_loop_is_said_where_it_stands() {
    // A triangle.
    let text = [
        GROUND,
        RUN,
        &hinge("A", "ground", ""),
        &arm("a", "A", [0.0, 1.0, 0.0]),
        &arm("f", "ground", [1.0, 0.0, 0.0]),
        &hinge("D", "f", ""),
        &arm("d", "D", [0.0, 1.0, 0.0]),
        &hinge("C", "a", "child = \"d\""),
        &body("A"),
    ];
    let message = "loop closed by joint C has no freedom left";
    check(&text.concat(), "\"C\"", message, "");
    // A support of what hangs, and a drive of what follows through a gear.
    let text = model(["", "", ""]);
    let held = text.clone() + "[[supports]]\nnode = \"rocker tip\"\nfix = \"all\"\n";
    check(&held, "\"rocker tip\"", "cannot be prescribed", "");
    let geared = [
        GROUND,
        RUN,
        &hinge("M", "ground", ""),
        &hinge("N", "ground", "prescribed = { proportional = 1 }"),
        &body("M"),
        &body("N"),
        "[[gears]]\njoints = [\"M\", \"N\"]\nratio = 2\n",
    ];
    check(&geared.concat(), "{ proportional", "N angle follows", "");
}
