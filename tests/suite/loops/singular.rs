//! Loops that come to a singular configuration in mid-run: they pass it, or end with its name.
#![allow(clippy::unwrap_used)]

use crate::support::program::{directory, history, number, program, write};
use std::f64::consts::PI;

/// Equal cranks of length 1 on a coupler and a ground of length 2: flat where they lie along it. With
/// bodies on all three bars and nothing else θ̇ is constant, as θ is all there is.
fn parallelogram(crank: &str, to: f64) -> String {
    let hinge = |name: &str, master: &str, more: &str| {
        format!(
            "[[joints]]\nname = \"{name}\"\ntype = \"revolute\"\nmaster = \"{master}\"\n\
             axis = [0, 0, 1]\n{more}\n"
        )
    };
    let arm = |name: &str, master: &str, place: [i32; 3]| {
        format!(
            "[[joints]]\nname = \"{name}\"\ntype = \"offset\"\nmaster = \"{master}\"\n\
             place = {place:?}\n"
        )
    };
    let body = |node: &str| {
        format!(
            "[[bodies]]\nname = \"bar {node}\"\nnode = \"{node}\"\nmass = 1\ninertia = [1, 1, 1]\n\
             [[probes]]\nname = \"{node}\"\nquantity = \"joint_coordinate\"\njoint = \"{node}\"\n"
        )
    };
    let support = "[nodes]\nground = [0, 0, 0]\n[[supports]]\nnode = \"ground\"\nfix = \"all\"\n";
    [
        support.to_owned(),
        hinge("A", "ground", crank),
        arm("a", "A", [0, 1, 0]),
        hinge("B", "a", ""),
        arm("b", "B", [2, 1, 0]),
        arm("foot", "ground", [2, 0, 0]),
        hinge("D", "foot", ""),
        arm("d", "D", [2, 1, 0]),
        hinge("C", "b", "child = \"d\""),
        ["A", "B", "D"].map(body).concat(),
        format!("[analysis.dynamic]\nto = {to}\nstep = 0.002\n"),
        "[output]\nparaview_every = 0\nfigures = false\n".to_owned(),
    ]
    .concat()
}

/// Runs it, and checks that rows are those of a parallelogram and the end is one, or named.
fn run(name: &str, crank: &str, rate: f64, to: f64) {
    let out = directory(name);
    let ran = program(&[&write(&out, &parallelogram(crank, to))]);
    let rows = history(&out.join("model.out"));
    for row in &rows {
        let [t, a, d] = ["t", "A", "D"].map(|c| number(row, c));
        assert!(
            (a - rate * t).abs() < 1e-6 * (1.0 + a.abs()),
            "{crank}: {a} at {t}"
        );
        assert!((a - d).abs() < 1e-6, "{crank}: {a} and {d} at {t}");
    }
    let end = rows.last().map_or(0.0, |row| number(row, "t"));
    let said = String::from_utf8_lossy(&ran.stderr);
    if ran.status.success() {
        assert!((end - to).abs() < 1e-9);
        return;
    }
    // The cranks lie along the ground at the next odd number of right angles.
    let flat = ((rate * end / PI - 0.5).round() + 0.5) * PI;
    assert!(
        (rate * end - flat).abs() < 0.2,
        "{crank}: ends at {end}\n{said}"
    );
    for words in ["singular", "joint C", "B angle", "D angle"] {
        assert!(said.contains(words), "{crank}: no {words}\n{said}");
    }
    assert!(!said.contains("reaches"), "{said}");
}

#[test]
fn a_free_parallelogram_passes_flat_positions_or_names_them() {
    for (k, rate) in [3.0, 0.5 * PI, 5.0, 10.0, 4.0 * PI, 5.0 * PI, 20.0]
        .into_iter()
        .enumerate()
    {
        run(
            &format!("loops_singular_{k}"),
            &format!("rate = {rate}"),
            rate,
            1.0,
        );
    }
}

#[test]
fn a_driven_one_is_not_said_to_be_at_the_end_of_its_reach() {
    for (k, rate) in [1.0, 0.5 * PI, 2.0].into_iter().enumerate() {
        let crank = format!("driven = {{ proportional = {rate} }}");
        run(&format!("loops_singular_driven_{k}"), &crank, rate, 2.0);
    }
}
