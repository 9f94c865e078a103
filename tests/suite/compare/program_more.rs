//! `pullback compare` with all its options, and on every model of the gallery that moves.

use crate::support::comparisons::{BODY, precession};
use crate::support::dynamics::assert_order;
use crate::support::program::*;
use nalgebra::Vector3;
use pullback::input::{Plan, assemble_text, with_parameters};
use pullback::studies::gallery::MODELS;
use serde_json::Value;
use std::fmt::Write;
use std::path::Path;

/// A free symmetrical body that also moves along, for a second.
fn body() -> String {
    let changes = "[3, 0, 4] => &\\nvelocity = [1, 2, 3]\nto = 2 => to = 1";
    changed(BODY, changes)
}

/// What compare.json says, of a comparison that ends well.
#[track_caller]
fn compared(model: &Path, words: &str) -> Value {
    succeeded(&compare(model, words));
    written(model)
}

/// What compare.json of a model says.
fn written(model: &Path) -> Value {
    json(model.with_extension("compare").join("compare.json"))
}

/// How many rows of compare.csv begin so.
fn count(model: &Path, start: &str) -> usize {
    let csv = read(model.with_extension("compare").join("compare.csv"));
    csv.lines().filter(|line| line.starts_with(start)).count()
}

fn rows<'a>(json: &'a Value, scheme: &'a str) -> impl Iterator<Item = &'a Value> + 'a {
    let rows = json["rows"].as_array().unwrap().iter();
    rows.filter(move |row| row["scheme"] == scheme)
}

/// The exact motion as a file: positions, rotation vectors, angular velocities and their
/// rates at k/50.
fn exact_motion() -> String {
    let axis = Vector3::new(3.0, 0.0, 2.0);
    let names = [
        "position",
        "rotation",
        "angular_velocity",
        "angular_acceleration",
    ];
    let columns = names.map(|n| ["x", "y", "z"].map(|k| format!("O.{n}.{k}")).join(","));
    let mut out = format!("t,{}\n", columns.join(","));
    for k in 0..=50 {
        let t = f64::from(k) / 50.0;
        let [turned, rotation] = precession(t);
        let omega = turned * Vector3::new(3.0, 0.0, 4.0);
        write!(out, "{t:e}").unwrap();
        let moved = Vector3::new(1.0, 2.0, 3.0) * t;
        for vector in [moved, rotation.scaled_axis(), omega, axis.cross(&omega)] {
            vector.iter().for_each(|x| write!(out, ",{x:e}").unwrap());
        }
        out.push('\n');
    }
    out
}

#[test]
fn an_exact_solution_comes_from_a_file() {
    let model = write(&directory("program_compare_exact"), &body());
    let file = model.with_file_name("exact.csv");
    std::fs::write(&file, exact_motion()).unwrap();
    let exact = "--exact exact.csv -q --residual 1e-12 --schemes";
    let asked = format!("{exact} newmark,radau --steps 0.02,0.01,0.005");
    let json = compared(&model, &asked);
    let reference = json["reference"]["scheme"].as_str().unwrap();
    assert!(reference.starts_with("exact, ") && reference.ends_with("exact.csv"));
    let known = ["rotation", "angular_velocity", "angular_acceleration"];
    for (scheme, order) in [("newmark", 2.0), ("radau", 3.0)] {
        for quantity in known {
            let errors: Vec<f64> = rows(&json, scheme)
                .map(|row| row["error"][quantity].as_f64().unwrap())
                .collect();
            assert_eq!(errors.len(), 3);
            assert_order(format!("{scheme}, {quantity}"), &errors, order, 0.1);
        }
        for row in rows(&json, scheme) {
            // Positions go on linearly, and steps are exact for them.
            assert!(row["error"]["position"].as_f64().unwrap() < 1e-12, "{row}");
            assert!(row["error"]["velocity"].is_null(), "{row}");
        }
    }
    // What the file does not say is empty in the table.
    let table = read(model.with_extension("compare").join("compare.csv"));
    assert!(!table.contains("NaN"), "{table}");
    let page = read(model.with_extension("compare").join("compare.md"));
    let given = "Errors are those against a solution that is given";
    assert_says(&page, &[given]);
    // A file that does not go with the steps says which times are looked at.
    let refused = compare(&model, &format!("{exact} newmark --steps 0.03,0.01"));
    assert_says(&ended(&refused, 2), &["there is no row for t = "]);
    // What it says twice it says once, and something.
    let text = exact_motion();
    let (head, body) = text.split_once('\n').unwrap();
    let (first, _) = body.split_once('\n').unwrap();
    let name = head.rsplit(',').next().unwrap();
    let last = first.rsplit(',').next().unwrap();
    let other = first.strip_suffix(last).unwrap().to_owned() + "7.5";
    let twice = text.replacen("t,", &format!("{name},t,"), 1);
    for (wrong, word) in [
        (twice, "is there twice"),
        (format!("{head}\n{other}\n{body}"), "contradict each other"),
        ("t\n0\n".to_owned(), "nothing is known in it but times"),
        (text.replacen("t,", "\u{feff}time,", 1), "column `time`"),
        (text.replacen("t,O.", "t,body.", 1), "no node `body`"),
        (
            text.replacen("position.z", "height", 1),
            "is not one of t, energy",
        ),
    ] {
        std::fs::write(&file, &wrong).unwrap();
        assert_says(&ended(&compare(&model, &asked), 2), &[word]);
    }
}

#[test]
fn a_search_that_finds_nothing_is_apart_too() {
    // Nothing is kept by a pendulum on its pin but energy.
    let model = write(&directory("program_compare_search"), &example("pendulum"));
    let json = compared(&model, "--schemes projected-newmark --steps 4x,2x -q");
    for row in rows(&json, "projected-newmark") {
        let [before, all] = ["searching", "assemblies"].map(|key| row[key].as_u64().unwrap());
        assert!(before > 0);
        assert_eq!(all, row["counts"]["evaluations"].as_u64().unwrap());
    }
}

#[test]
fn times_are_taken_alone_where_they_are_asked_for() {
    let model = write(&directory("program_compare_timed"), &body());
    let schemes = "newmark,lie-newmark,projected-newmark,central-difference,radau";
    let asked = format!("--schemes {schemes} --steps 0.02,0.0005 -q");
    let json = compared(&model, &asked);
    assert!(json["equal_time"].is_null());
    let all = json["rows"].as_array().unwrap();
    assert!(all.iter().all(|row| row["seconds_alone"].is_null()));
    // What an evaluation of spins costs is counted: with a tangent it is three.
    let counts = |row: &Value| {
        [&row["assemblies"], &row["counts"]["evaluations"]].map(|x| x.as_u64().unwrap())
    };
    // What a scheme looks for before its first step is apart, whatever the number of steps. The matrix of
    // two stages of Radau's takes two tangents of each.
    for (scheme, searches) in [
        ("newmark", false),
        ("projected-newmark", true),
        ("central-difference", true),
        ("radau", false),
    ] {
        for row in rows(&json, scheme) {
            let [assemblies, evaluations] = counts(row);
            assert_eq!(assemblies, evaluations, "{scheme}");
            let before = row["searching"].as_u64().unwrap();
            assert_eq!(before > 0, searches, "{scheme}: {before}");
        }
    }
    // A solution in every step, and a residual that shows the balance: each evaluates two stages.
    for row in rows(&json, "radau") {
        let [evaluations, iterations, steps] =
            ["evaluations", "iterations", "steps"].map(|key| row["counts"][key].as_u64().unwrap());
        assert!(evaluations <= 2 * (iterations + 2 * steps) + 1, "{row}");
    }
    for [assemblies, evaluations] in rows(&json, "lie-newmark").map(counts) {
        // Of two evaluations per step or more one at least is a last residual.
        let between = evaluations < assemblies && assemblies < 3 * evaluations;
        assert!(between, "{assemblies} {evaluations}");
    }
    let json = compared(&model, &(asked + " --timed --charts"));
    for scheme in ["newmark", "lie-newmark"] {
        let times: Vec<f64> = rows(&json, scheme)
            .map(|row| row["seconds_alone"].as_f64().unwrap())
            .collect();
        // Forty times the steps take longer.
        let longer = times[0] > 0.0 && times[1] > 2.0 * times[0];
        assert!(longer, "{scheme}: {times:?}");
    }
    assert_eq!(json["equal_time"]["seconds"], true);
    assert_eq!(json["equal_cost"]["seconds"], false);
    assert_eq!(json["charts"].as_array().unwrap().len(), 10);
    let page = read(model.with_extension("compare").join("compare.md"));
    let equal = ["\n## Errors at equal work\n", "\n## Errors at equal time\n"];
    assert_says(&page, &equal);
    assert_says(&page, &["\n## What changes of chart cost\n"]);
    assert_eq!(count(&model, "charts,"), 10);
}

/// Momenta and constraints over a long run: by theory, not by an earlier one.
#[test]
fn long_runs_tell_what_becomes_of_momenta_and_constraints() {
    let model = write(&directory("program_compare_long"), &body());
    let schemes = ["newmark", "projected-newmark"];
    let asked = "--steps 0.02,0.01 --long 5 -q --residual 1e-13 --schemes";
    let json = compared(&model, &format!("{asked} {}", schemes.join(",")));
    let long = |scheme: &str, what: &str| {
        let rows = json["long"].as_array().unwrap();
        let row = rows.iter().find(|row| row["scheme"] == scheme).unwrap();
        assert!(row["failure"].is_null());
        row["drift"][what].as_f64().unwrap()
    };
    let kept = &json["reference"]["conserved"];
    for momentum in ["momentum", "angular_momentum"] {
        assert_eq!(kept[momentum], serde_json::json!([true, true, true]));
    }
    // Positions go on linearly, and Newmark's scheme is exact for them; angular momenta are kept by `projected-newmark` alone.
    for scheme in schemes {
        assert!(long(scheme, "momentum") < 1e-11);
    }
    // The centre of mass moves, |L| = √52 about it: 5 s at 0.02 are far from exact.
    let [lost, kept] = schemes.map(|s| long(s, "angular_momentum"));
    assert!(lost > 1e-5 && kept < 1e-10, "{lost:e} {kept:e}");
    assert_eq!(count(&model, "long,"), 2);
}

/// The same model for a few of its own steps, and their size.
fn short(text: &str) -> Option<(String, f64)> {
    let Plan::Dynamic(plan) = assemble_text("model.toml", text).unwrap().plan else {
        return None;
    };
    let (to, step) = (plan.options.to, plan.options.step);
    let to = to.min(8.0 * step).to_string();
    let text = with_parameters(text, [("analysis.dynamic.to", &to[..])]);
    Some((text.unwrap(), step))
}

#[test]
fn the_command_runs_on_every_model_of_the_gallery_that_moves() {
    let directory = directory("program_compare_gallery");
    let expected = super::program::written();
    let mut seen = 0;
    for (name, text) in MODELS {
        let Some((text, step)) = short(text) else {
            continue;
        };
        seen += 1;
        let model = directory.join(format!("{name}.toml"));
        std::fs::write(&model, text).unwrap();
        let schemes = "newmark,ga:0.8,projected-newmark:0.8,bathe,lie-ga:0.8";
        let asked = format!("--schemes {schemes} --steps {},{step} -q", 2.0 * step);
        // The few steps of this one resolve none of the vibrations of its bars: there is no reference.
        let json = match name == &"four_bar_misaligned" {
            false => compared(&model, &asked),
            true => {
                let said = ended(&compare(&model, &asked), 1);
                assert_says(&said, &["no reference for any quantity"]);
                written(&model)
            }
        };
        assert_eq!(json["complete"], true, "{name}");
        let damped = ["ga:0.8", "projected-newmark:0.8", "bathe"];
        for row in damped.iter().flat_map(|scheme| rows(&json, scheme)) {
            assert!(row["failure"].is_null(), "{name}: {row}");
            assert!(row["error"]["energy"].as_f64().is_some(), "{name}: {row}");
        }
        // A model without free rotations refuses the formulation, and one whose loops need damping the scheme.
        for row in json["rows"].as_array().unwrap() {
            let reason = row["failure"].as_str().unwrap_or("prefix");
            let known = reason.contains("prefix") || reason.contains("multiplier");
            assert!(known, "{name}: {reason}");
        }
        let found = files(&model.with_extension("compare"));
        // Where no error is larger than that of the reference there is none to draw.
        let above = |row: &Value, (quantity, least): (&String, &Value)| {
            let error = row["error"][quantity].as_f64();
            error.is_some_and(|e| e > least.as_f64().unwrap_or(f64::INFINITY))
        };
        let least = json["reference"]["error"].as_object().unwrap();
        let mut all = json["rows"].as_array().unwrap().iter();
        let drawn = all.any(|row| least.iter().any(|known| above(row, known)));
        let expected = expected
            .iter()
            .filter(|file| drawn || !["convergence.svg", "work.svg"].contains(&file.as_str()));
        assert!(found.iter().eq(expected), "{name}: {found:?}");
    }
    assert!(seen >= 20, "{seen}");
}

/// The pendulum and the free body are known; another formulation of them, Radau IIA's steps, says the same.
#[test]
fn motions_of_the_gallery_that_are_known_are_the_reference() {
    for name in ["pendulum", "free_body"] {
        let directory = directory(&format!("program_compare_exact_{name}"));
        let compared = |more: &str, out: &str| {
            let asked = "--schemes newmark --steps 4x,2x,1x --out";
            printed(&directory, &format!("compare {name} {asked} {out}{more}"));
            json(directory.join(out).join("compare.json"))
        };
        let exact = compared("", "exact");
        assert_eq!(exact["reference"]["scheme"], "Jacobi's elliptic functions");
        let radau = compared(" --reference radau", "radau");
        for quantity in ["rotation", "angular_velocity", "angular_acceleration"] {
            for (a, b) in rows(&exact, "newmark").zip(rows(&radau, "newmark")) {
                let [a, b] = [a, b].map(|row| row["error"][quantity].as_f64().unwrap());
                let what = format!("{name}, {quantity}: {a:e} {b:e}");
                assert!(a > 0.0 && (a - b).abs() < 0.01 * a, "{what}");
            }
        }
    }
}
