//! `[analysis.modes]` and `pullback linearize`.
#![allow(clippy::unwrap_used, non_snake_case)]

use crate::support::beams::{COLUMN, PINNED, line};
use crate::support::program::{
    MODEL, command, directory, ended, matrix, program, results, succeeded, write,
};
use nalgebra::DMatrix;
use pullback::input::assemble_text;
use pullback::run;
use pullback::solve::Advance;
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// A bar of two masses 3 and 1 between springs 2 and 1 along x, from the ground.
const MASSES: &str = r#"
[nodes]
ground = [0, 0, 0]
a = [1, 0, 0]
b = [2, 0, 0]
[[bodies]]
name = "a"
node = "a"
mass = 3
[[bodies]]
name = "b"
node = "b"
mass = 1
[[springs]]
name = "first"
nodes = ["ground", "a"]
stiffness = 2
[[springs]]
name = "second"
nodes = ["a", "b"]
stiffness = 1
[[supports]]
node = "ground"
fix = "all"
[[supports]]
node = "a"
fix = ["y", "z", "rx", "ry", "rz"]
[[supports]]
node = "b"
fix = ["y", "z", "rx", "ry", "rz"]
"#;

fn run(name: &str, model: &str) -> (std::path::PathBuf, std::process::Output) {
    let out = directory(name);
    let ran = program(&[&write(&out, model)]);
    (out.join("model.out"), ran)
}

/// Frequencies of 3ẍ₁ + 3x₁ − x₂ = 0, ẍ₂ + x₂ − x₁ = 0: 3s² − 6s + 2 = 0 in s = ω².
fn exact() -> [f64; 2] {
    [-1.0, 1.0].map(|sign: f64| (1.0 + sign / 3.0_f64.sqrt()).sqrt() / TAU)
}

#[test]
fn a_run_in_memory_warns_as_one_with_files() {
    let texts = [
        format!("{MASSES}\n[analysis.modes]\ncount = 50\n"),
        format!("{}\n[analysis.buckling]\ncount = 50\n", column()),
    ];
    for (k, text) in texts.iter().enumerate() {
        let path = write(&directory(&format!("in memory {k}")), text);
        let go = &mut |_: &Advance<'_>| ControlFlow::Continue(());
        let files = run::run(&path, None, go).unwrap();
        let job = assemble_text("model.toml", text).unwrap();
        let memory = run::record_job(job, &mut |_| {}, go).unwrap();
        assert_eq!(memory.warnings, files.warnings);
        assert_eq!(memory.notes, files.notes);
        let fewer = |warning: &String| warning.contains("fewer than count = 50");
        assert!(files.warnings.iter().any(fewer), "{:?}", files.warnings);
    }
}

#[test]
fn modes_of_two_masses() {
    let (out, ran) = run(
        "two masses",
        &format!("{MASSES}\n[analysis.modes]\ncount = 5\n"),
    );
    let said = succeeded(&ran);
    assert!(
        said.contains("the model has 2 modes, fewer than count = 5"),
        "{said}"
    );
    let warnings = results(&out)["warnings"].to_string();
    assert!(warnings.contains("the model has 2 modes"), "{warnings}");
    let table = std::fs::read_to_string(out.join("modes.csv")).unwrap();
    let rows: Vec<Vec<f64>> = (table.lines().skip(1))
        .map(|row| row.split(',').map(|x| x.parse().unwrap()).collect())
        .collect();
    let mut mass = 0.0;
    for (row, exact) in rows.iter().zip(exact()) {
        assert!((row[1] / exact - 1.0).abs() < 1e-14, "{row:?} {exact}");
        mass += row[9];
    }
    // All mass moves with the two modes.
    assert!(rows.len() == 2 && (mass - 4.0).abs() < 1e-12, "{mass}");
    let json = std::fs::read_to_string(out.join("modes.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["modes"].as_array().unwrap().len(), 2);
    for file in ["mode_01.svg", "mode_02.pvd", "mode_02_11.vtu"] {
        assert!(out.join(file).is_file(), "{file}");
    }
}

#[test]
fn a_range_without_modes_is_an_error() {
    let text = format!("{MASSES}\n[analysis.modes]\nrange = [10, 20]\n");
    let (_, ran) = run("no modes", &text);
    let said = String::from_utf8_lossy(&ran.stderr);
    assert_eq!(ran.status.code(), Some(1));
    assert!(
        said.contains("no mode has a frequency between 10 and 20"),
        "{said}"
    );
}

#[test]
fn a_model_without_mass_has_no_modes() {
    let text = MODEL.replace(
        "[analysis.static]\nsteps = 4",
        "[analysis.modes]\nafter = { static = { steps = 4 } }",
    );
    let (_, ran) = run("no mass", &text);
    let said = String::from_utf8_lossy(&ran.stderr);
    assert_eq!(ran.status.code(), Some(1));
    assert!(said.contains("no coordinate has mass"), "{said}");
}

#[test]
fn settings_of_modes_are_checked() {
    for (keys, problem) in [
        ("count = 0", "count"),
        ("near = -1.0", "near"),
        ("range = [2, 1]", "range = [2, 1] is out of range"),
        ("near = 1.0\nrange = [1, 2]", "near"),
        ("after = { modes = {} }", "modes"),
        ("number = 3", "number"),
    ] {
        let text = format!("{MASSES}\n[analysis.modes]\n{keys}\n");
        let error = assemble_text("model.toml", &text).err().unwrap();
        let said = error.report(false);
        assert!(said.contains(problem), "{keys}: {said}");
    }
    let after = "after = { dynamic = { to = 1, step = 0.1 } }";
    let text = format!("{MASSES}\n[analysis.buckling]\n{after}\n");
    let said = assemble_text("model.toml", &text)
        .err()
        .unwrap()
        .report(false);
    assert!(said.contains("unknown key or word `dynamic`"), "{said}");
}

/// A pinned column of elements of order one with EA = GA: 4 EI/h² tan²(πh/2L).
fn column() -> String {
    line(COLUMN, 8, 1, PINNED)
}

#[test]
fn critical_loads_of_a_column() {
    for after in ["", "after = { static = { to = 4.0 } }"] {
        let text = format!("{}\n[analysis.buckling]\ncount = 2\n{after}\n", column());
        let (out, ran) = run("buckling", &text);
        succeeded(&ran);
        let table = std::fs::read_to_string(out.join("buckling.csv")).unwrap();
        let loads = table
            .lines()
            .skip(1)
            .map(|row| row.split(',').nth(1).unwrap().parse());
        let loads: Vec<f64> = loads.map(Result::unwrap).collect();
        for (load, EI) in loads.iter().zip([1.0, 3.0]) {
            let exact = 256.0 * EI * (std::f64::consts::PI / 16.0).tan().powi(2);
            assert!((load / exact - 1.0).abs() < 1e-6, "{load} {exact}");
        }
        assert!(loads.len() == 2 && out.join("mode_02.svg").is_file());
    }
}

#[test]
fn an_unstable_equilibrium_has_no_critical_loads() {
    let after = "after = { static = { to = 12.0 } }";
    let (_, ran) = run(
        "unstable",
        &format!("{}\n[analysis.buckling]\n{after}\n", column()),
    );
    let said = String::from_utf8_lossy(&ran.stderr);
    assert_eq!(ran.status.code(), Some(1));
    assert!(said.contains("is not stable"), "{said}");
}

#[test]
fn matrices_at_the_end_of_a_path_that_does_not_end() {
    let out = directory("no end");
    let path = "[analysis.arc_length]\nmax_steps = 1\n";
    let ran = command("linearize", &[&write(&out, &(column() + path))]);
    let said = ended(&ran, 1);
    assert!(said.contains("within max_steps = 1"), "{said}");
}

#[test]
fn matrices_of_two_masses() {
    let out = directory("matrices");
    let model = write(&out, &format!("{MASSES}\n[analysis.modes]\n"));
    succeeded(&command("linearize", &[&model]));
    for (name, known) in [
        ("K.mtx", [3.0, -1.0, -1.0, 1.0]),
        ("M.mtx", [3.0, 0.0, 0.0, 1.0]),
        ("C.mtx", [0.0; 4]),
    ] {
        let found = matrix(&out.join("model.linear").join(name));
        assert_eq!(found, DMatrix::from_row_slice(2, 2, &known));
    }
    let names = std::fs::read_to_string(out.join("model.linear/coordinates.txt")).unwrap();
    assert_eq!(
        names,
        "node a, displacement along e1\nnode b, displacement along e1\n"
    );
}

#[test]
fn matrices_of_a_motion_are_those_of_an_instant() {
    let out = directory("moving matrices");
    let motion = "[[initial]]\nnode = \"a\"\nvelocity = [1, 0, 0]\n[analysis.dynamic]\nto = 0.1\nstep = 0.01\n";
    let ran = command("linearize", &[&write(&out, &format!("{MASSES}\n{motion}"))]);
    let said = succeeded(&ran);
    assert!(said.contains("warning: the state moves"), "{said}");
}
