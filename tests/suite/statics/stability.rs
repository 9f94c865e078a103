//! Stability of equilibria by the signs of pivots: columns against Euler's loads, arches at their
//! limit points.
#![allow(clippy::unwrap_used, non_snake_case)]

use crate::support::beams::{COLUMN, PINNED, line};
use crate::support::program::{directory, history, number, program, results, succeeded, write};
use pullback::input::{Plan, assemble_text};
use pullback::integrators::statics::{Step, solve_statics, trace_path};
use pullback::prelude::*;
use std::f64::consts::PI;
use std::ops::ControlFlow;

/// Elements of a column.
const ELEMENTS: usize = 16;

fn column(analysis: &str) -> String {
    line(COLUMN, ELEMENTS, 1, &format!("{PINNED}{analysis}"))
}

/// Critical loads up to `most` of half waves in bending with the stiffness EI.
///
/// With EA = GA the equation of the beam is EI φ″ + P φ = 0 exactly: the compression P/EA takes from
/// the lever arm what the shear P/GA gives to it. Elements with linear interpolation and one
/// integration point make it EI (φ₊ − 2φ + φ₋)/h² + P (φ₊ + 2φ + φ₋)/4 = 0 with the
/// solutions cos(kπx/L), P = 4 EI/h² tan²(kπh/2L).
fn euler_loads(EI: f64, most: f64) -> Vec<f64> {
    let n = ELEMENTS as f64;
    (1..)
        .map(|k| 4.0 * EI * n * n * (f64::from(k) * PI / (2.0 * n)).tan().powi(2))
        .take_while(|P| *P < most)
        .collect()
}

/// Load and unstable directions of each row.
fn counts(text: &str) -> Vec<(f64, Option<usize>)> {
    let mut job = assemble_text("column.toml", text).unwrap();
    let mut found = Vec::new();
    let mut observe = |_: &mut Context, step: &Step<'_>| {
        found.push((step.t, step.unstable));
        ControlFlow::Continue(())
    };
    match &job.plan {
        Plan::Static(options) => {
            solve_statics(&mut job.context, &mut vec![], options, &mut observe).unwrap();
        }
        Plan::Path(options, _) => {
            trace_path(&mut job.context, &mut vec![], options, &mut observe).unwrap();
        }
        _ => unreachable!("a motion"),
    }
    found
}

#[test]
fn each_eulers_load_of_a_straight_column_is_one_more_direction() {
    let most = 110.0;
    let mut critical = euler_loads(1.0, most);
    critical.extend(euler_loads(3.0, most));
    assert_eq!(critical.len(), 4);
    // To 1e-6 of the critical loads, by load steps that end there.
    for P in &critical {
        for to in [P * (1.0 - 1e-6), P * (1.0 + 1e-6)] {
            let steps = format!("[analysis.static]\nto = {to:?}\nsteps = 3");
            let rows = counts(&column(&steps));
            assert_eq!(rows.len(), 3);
            for (t, unstable) in rows {
                let passed = critical.iter().filter(|P| **P < t).count();
                assert_eq!(unstable, Some(passed), "P = {t}");
            }
        }
    }
    // Along the path.
    let path = "[analysis.arc_length]\nload_scale = 30\nstop = [{ load = 110 }]\n\
                record = [{ load = 9.8 }, { load = 9.95 }]";
    let rows = counts(&column(path));
    assert!(rows.len() > 20);
    for (t, unstable) in rows {
        let passed = critical.iter().filter(|P| **P < t).count();
        assert_eq!(unstable, Some(passed), "P = {t}");
    }
}

#[test]
fn multipliers_do_not_count() {
    // The hinge at A as a joint that is closed by multipliers, one of six equations redundant or not.
    let pinned = "node = \"A\"\nfix = [\"x\", \"y\", \"z\"]";
    let hinged = r#"
        node = "G"
        fix = "all"
        [[joints]]
        name = "hinge"
        type = "revolute"
        parent = "G"
        axis = [0, 0, 1]
        child = "A"
        closure = "multipliers"
    "#;
    let first = euler_loads(1.0, 20.0)[0];
    for (load, expected) in [(0.99 * first, 0), (1.01 * first, 1)] {
        let steps = format!("[analysis.static]\nto = {load:?}\nsteps = 2");
        let text = column(&steps).replace("A = [0, 0, 0]", "A = [0, 0, 0]\nG = [0, 0, 0]");
        assert!(text.contains(pinned));
        let rows = counts(&text.replace(pinned, hinged));
        assert_eq!(rows[0].1, Some(0), "{load}");
        assert_eq!(rows[1].1, Some(expected), "{load}");
    }
}

#[test]
fn a_column_beyond_its_load_is_warned_of() {
    let directory = directory("stability_column");
    let first = euler_loads(1.0, 20.0)[0];
    let steps = format!("[analysis.static]\nto = {}\nsteps = 2", 1.5 * first);
    let model = write(&directory, &column(&steps));
    let said = succeeded(&program(&[&model]));
    let result = results(&directory.join("model.out"));
    let warnings = result["warnings"].as_array().unwrap();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    let words = warnings[0].as_str().unwrap();
    assert!(said.contains(words), "{said}");
    let span = format!(
        "between load parameter {:.4}",
        (0.75 * first * 1e4).floor() / 1e4
    );
    for part in [
        &span,
        "bifurcation",
        "unstable in 1 direction",
        "imperfection",
        "max_step",
    ] {
        assert!(words.contains(part), "{part}: {words}");
    }
    assert_eq!(result["last"]["unstable"], 1);
    let rows = history(&directory.join("model.out"));
    let column: Vec<&str> = rows.iter().map(|r| r["unstable"].as_str()).collect();
    assert_eq!(column, ["", "0", "1"]);
}

#[test]
fn a_deep_arch_is_unstable_from_its_limit_point_on() {
    let directory = directory("stability_arch");
    let example = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/examples/models/deep_arch.toml"
    );
    let out = directory.join("out");
    succeeded(&program(&[example.as_ref(), "--out".as_ref(), &out]));
    let rows = history(&out);
    let turning = rows.iter().position(|r| r["event"] == "turning_point");
    let turning = turning.unwrap();
    // Where the tangent is singular nothing can be said.
    assert_eq!(rows[turning]["unstable"], "");
    let known = |row: &&std::collections::HashMap<String, String>| !row["unstable"].is_empty();
    assert!(
        rows[1..turning]
            .iter()
            .all(|r| number(r, "unstable") == 0.0)
    );
    for row in rows[turning..].iter().filter(known) {
        assert_eq!(number(row, "unstable"), 1.0, "load {}", row["t"]);
    }
    let result = results(&out);
    let words = result["warnings"][0].as_str().unwrap();
    assert!(words.contains("limit point"), "{words}");
}
