//! Loops that come to a singular configuration in mid-run: their maps end there, and it is named.

use crate::support::closures::{GROUND, PLAIN, angle, arm, body, hinge, joint, motion};
use crate::support::prelude::*;
use crate::support::program::{assert_close, directory, example, history, number, program, write};

/// Equal cranks of length 1 on a coupler and a ground of length 2: flat where they lie along it. With
/// bodies on all three bars and nothing else θ̇ is constant, as θ is all there is.
fn parallelogram(crank: &str, to: f64) -> String {
    let bars = ["A", "B", "D"];
    [
        GROUND,
        &hinge("A", "ground", crank),
        &arm("a", "A", [0.0, 1.0, 0.0]),
        &hinge("B", "a", ""),
        &arm("b", "B", [2.0, 1.0, 0.0]),
        &arm("foot", "ground", [2.0, 0.0, 0.0]),
        &hinge("D", "foot", ""),
        &arm("d", "D", [2.0, 1.0, 0.0]),
        &hinge("C", "b", "child = \"d\""),
        &bars.map(body).concat(),
        &bars.map(angle).concat(),
        &format!("[analysis.dynamic]\nto = {to}\nstep = 0.002\n"),
        PLAIN,
    ]
    .concat()
}

/// Runs it, and checks that rows are those of a parallelogram up to the first flat position, which is named.
fn run(name: &str, crank: &str, rate: f64, to: f64) {
    let out = directory(name);
    let ran = program(&[&write(&out, &parallelogram(crank, to))]);
    let rows = history(&out.join("model.out"));
    for row in &rows {
        let [t, a, d] = ["t", "A", "D"].map(|c| number(row, c));
        assert_close(a, rate * t, 1e-6 * (1.0 + a.abs()), crank);
        assert!((a - d).abs() < 1e-6, "{crank}: {a} and {d} at {t}");
    }
    let end = rows.last().map_or(0.0, |row| number(row, "t"));
    let said = String::from_utf8_lossy(&ran.stderr);
    let flat = 0.5 * PI;
    if ran.status.success() {
        assert!((end - to).abs() < 1e-9 && rate * to <= flat);
        return;
    }
    assert_close(rate * end, flat, 0.01, format_args!("{crank}: {said}"));
    for words in ["singular", "joint C", "B angle", "D angle", MULTIPLIERS] {
        assert!(said.contains(words), "{crank}: no {words}\n{said}");
    }
    assert!(!said.contains("reaches"), "{said}");
}

const MULTIPLIERS: &str = "`closure = \"multipliers\"` goes through";

/// Parallelograms in a row (IFToMM's A02) without weight: all are flat at once.
fn in_a_row(closure: &str, analysis: &str) -> String {
    let model = example("parallelograms");
    let (model, _) = model.split_once("[[loads]]").unwrap();
    let model = model
        .replace("value = 1.2", "rate = 6")
        .replace("child =", &format!("closure = \"{closure}\"\nchild ="));
    let probe = angle("crank 0");
    format!("{model}[analysis.dynamic]\nto = 0.4\n{analysis}{probe}{PLAIN}")
}

#[test]
fn parallelograms_in_a_row_end_at_their_flat_position_whatever_the_steps() {
    let run = |closure: &str, scheme: &str, step: f64| {
        let analysis = format!("step = {step}\nscheme = {scheme}\n");
        let out = directory("parallelograms_in_a_row");
        let ran = program(&[&write(&out, &in_a_row(closure, &analysis))]);
        let rows = history(&out.join("model.out"));
        let angle = number(rows.last().unwrap(), "crank 0");
        (angle, String::from_utf8_lossy(&ran.stderr).into_owned())
    };
    let damped = "{ generalised-alpha = 0.8 }";
    for (scheme, step) in [
        ("\"newmark\"", 0.02),
        ("\"newmark\"", 0.011),
        ("\"newmark\"", 0.004),
        (damped, 0.02),
        (damped, 0.005),
        ("\"radau\"", 0.02),
        ("\"bathe\"", 0.013),
        ("\"projected-newmark\"", 0.01),
    ] {
        let (angle, said) = run("map", scheme, step);
        assert!((angle - 0.5 * PI).abs() < 1e-3, "{scheme} {step}: {angle}");
        assert!(said.contains(MULTIPLIERS), "{scheme} {step}: {said}");
    }
    let (angle, said) = run("multipliers", damped, 0.004);
    assert!(angle > 2.0 && !said.contains("error"), "{angle} {said}");
}

#[test]
fn a_free_parallelogram_ends_at_its_flat_position() {
    for rate in [3.0, 0.5 * PI, 5.0, 10.0, 4.0 * PI, 5.0 * PI, 20.0] {
        run("loops_singular", &format!("rate = {rate}"), rate, 1.0);
    }
}

#[test]
fn a_driven_one_is_not_said_to_be_at_the_end_of_its_reach() {
    for rate in [1.0, 0.5 * PI, 2.0] {
        let crank = format!("prescribed = {{ proportional = {rate} }}");
        run("loops_singular_driven", &crank, rate, 2.0);
    }
}

/// A rod of length 1 between two slides at right angles: x = sin t as prescribed, and y = cos t goes through zero where x
/// turns back.
#[test]
fn a_motion_that_turns_back_at_a_dead_centre_does_not_go_on_in_the_mirror_image() {
    let drive = "axis = [1, 0, 0]\nprescribed = { sine = { amplitude = 1, omega = 1 } }";
    for step in [0.3, 0.05, 0.007] {
        let text = [
            GROUND,
            &joint("x", "prismatic", "ground", drive),
            &hinge("A", "x", ""),
            &arm("tip", "A", [0.0, 1.0, 0.0]),
            &arm("foot", "ground", [0.0, 1.0, 0.0]),
            &joint("y", "prismatic", "foot", "axis = [0, 1, 0]"),
            &hinge("C", "tip", "child = \"y\""),
            &body("A"),
            &body("y"),
            &angle("y"),
            &motion(2.0, step),
            PLAIN,
        ];
        let out = directory("loops_singular_trammel");
        let ran = program(&[&write(&out, &text.concat())]);
        let rows = history(&out.join("model.out"));
        for row in &rows {
            let [t, y] = ["t", "y"].map(|c| number(row, c));
            assert_close(y, t.cos() - 1.0, 1e-7, format_args!("{step}: {t}"));
        }
        let end = number(rows.last().unwrap(), "t");
        let said = String::from_utf8_lossy(&ran.stderr);
        assert!(
            end > 1.57 && said.contains("coordinates of C: "),
            "{step}: {end} {said}"
        );
    }
}
