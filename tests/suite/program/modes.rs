//! `[analysis.modes]` and `pullback linearize`.

use super::resume::go_on;
use crate::support::beams::{COLUMN, PINNED, line};
use crate::support::*;
use nalgebra::DMatrix;
use pullback::input::assemble_text;
use pullback::run;
use std::f64::consts::{PI, TAU};

/// A bar of two masses 3 and 1 between springs 2 and 1 along x, from the ground; more of the file.
fn masses(more: &str) -> String {
    let on_rail = |node: &str, mass: f64, from: &str, stiffness: f64| {
        let spring =
            format!("[[springs]]\nname = \"at {node}\"\nnodes = [\"{from}\", \"{node}\"]\n");
        let rail = "fix = [\"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n";
        let support = format!("stiffness = {stiffness}\n[[supports]]\nnode = \"{node}\"\n{rail}");
        [body_of(node, mass, ""), spring, support].concat()
    };
    [
        "[nodes]\nground = [0, 0, 0]\na = [1, 0, 0]\nb = [2, 0, 0]\n",
        &fixed("ground"),
        &on_rail("a", 3.0, "ground", 2.0),
        &on_rail("b", 1.0, "a", 1.0),
        more,
    ]
    .concat()
}

/// Frequencies of 3ẍ₁ + 3x₁ − x₂ = 0, ẍ₂ + x₂ − x₁ = 0: 3s² − 6s + 2 = 0 in s = ω².
fn exact() -> [f64; 2] {
    [-1.0, 1.0].map(|sign: f64| (1.0 + sign / 3.0_f64.sqrt()).sqrt() / TAU)
}

#[test]
fn a_run_in_memory_warns_as_one_with_files() {
    let texts = [
        masses("[analysis.modes]\ncount = 50\n"),
        column("[analysis.buckling]\ncount = 50\n"),
    ];
    for (k, text) in texts.iter().enumerate() {
        let path = write(&directory(&format!("in memory {k}")), text);
        let files = run::run(&path, None, &mut go_on).unwrap();
        let job = assemble_text("model.toml", text).unwrap();
        let memory = run::record_job(job, &mut |_| {}, &mut go_on).unwrap();
        assert_eq!(memory.warnings, files.warnings);
        assert_eq!(memory.notes, files.notes);
        assert_says(&files.warnings.concat(), &["fewer than count = 50"]);
    }
}

#[test]
fn modes_of_two_masses() {
    let run = run_of("two masses", &masses("[analysis.modes]\ncount = 5\n"));
    let told = "the model has 2 modes, fewer than count = 5";
    assert_says(&run.result["warnings"].to_string(), &[told]);
    let rows = csv(run.out.join("modes.csv"));
    for (row, exact) in rows.iter().zip(exact()) {
        assert!((row[1] / exact - 1.0).abs() < 1e-14, "{row:?} {exact}");
    }
    // All mass moves with the two modes.
    assert_eq!(rows.len(), 2);
    assert_close(rows[0][9] + rows[1][9], 4.0, 1e-12, "mass");
    let modes = &json(run.out.join("modes.json"))["modes"];
    assert_eq!(modes.as_array().unwrap().len(), 2);
    for file in ["mode_01.svg", "mode_02.pvd", "mode_02_11.vtu"] {
        assert!(run.out.join(file).is_file(), "{file}");
    }
}

/// Masses side by side, ω² = 1e-7/3 and 1e7.
#[test]
fn a_mass_alone_leaves_the_inertia_of_material_and_shape() {
    let bar = "[sections.s]\ncircle = { radius = 0.1 }\nmaterial = { E = 100, nu = 0.3, rho = 1 }\n\
               mass = { A_rho = 0.0314159265358979 }\n[nodes]\na = [0, 0, 0]\nb = [2, 0, 0]\n\
               [[lines]]\nname = \"bar\"\nfrom = \"a\"\nto = \"b\"\nelements = 8\norder = 3\n\
               section = \"s\"\n[analysis.modes]\ncount = 6\n";
    let run = run_of("round bar", &(bar.to_owned() + &fixed("a")));
    // The first mode of torsion: √(G/ρ)/(4 L).
    let exact = (100.0 / 2.6_f64).sqrt() / 8.0;
    let rows = csv(run.out.join("modes.csv"));
    let near = |row: &Vec<f64>| (row[1] / exact - 1.0).abs() < 1e-6;
    assert!(rows.iter().any(near), "{rows:?} {exact}");
}

#[test]
fn modes_far_apart_are_all_found() {
    let text = masses("[analysis.modes]\ncount = 2\n")
        .replace("stiffness = 2", "stiffness = 1e-7")
        .replace("stiffness = 1\n", "stiffness = 1e7\n")
        .replace("[\"a\", \"b\"]", "[\"ground\", \"b\"]");
    let found = csv(ran(&directory("modes far apart"), &text).join("modes.csv"));
    for (found, exact) in found.iter().zip([1e-7 / 3.0, 1e7]) {
        assert_close(found[1] * TAU / f64::sqrt(exact), 1.0, 1e-10, "frequency");
    }
    let range = text.replace("count = 2", "range = [1, 1e4]");
    let [_, warnings] = told("modes far apart", &range);
    assert!(warnings.is_empty(), "{warnings:?}");
}

#[test]
fn why_there_are_no_modes_or_critical_loads_is_told() {
    let after =
        "[analysis.static] => [analysis.modes]\nsteps = 4 => after = { static = { steps = 4 } }";
    for (name, text, told) in [
        (
            "no modes",
            masses("[analysis.modes]\nrange = [10, 20]\n"),
            "no mode has a natural frequency |λ|/2π between 10 and 20",
        ),
        ("no mass", changed(MODEL, after), "no coordinate has mass"),
        (
            "unstable",
            column("[analysis.buckling]\nafter = { static = { to = 12.0 } }\n"),
            "is not stable",
        ),
        (
            "buckling mechanism",
            column("[analysis.buckling]\n").replace(", \"rx\"", ""),
            "node A, rotation about e1 (+1.000)",
        ),
    ] {
        assert_says(&failed(name, &text), &[told]);
    }
}

/// A hanging chain has the frequencies j √(g/L)/4π, where j are the zeros of the Bessel function J₀ (Daniel Bernoulli
/// 1733). Supports alone do not hold it.
#[test]
fn gravity_holds_a_hanging_cable() {
    let stiffness = "EA = 1e7, GA = [1e6, 1e6], GJ = 1e-5, EI = [1e-5, 1e-5]";
    let rest = r#"
[sections.main.mass]
A_rho = 2
J = [1e-12, 1e-12, 1e-12]
[[supports]]
node = "A"
fix = ["x", "y", "z", "rz"]
[[loads]]
gravity = [0, 0, -9.81]
time = { constant = 1 }
[analysis.modes]
count = 4
after.static.steps = 1
"#;
    let hanging = "B = [1, 0, 0] => B = [0, 0, -3]";
    let text = changed(&line(stiffness, 20, 3, rest), hanging);
    let run = run_of("hanging cable", &text);
    let words = [
        "can still move as a rigid body (rotation",
        "unless loads hold it",
    ];
    assert_says(&run.result["warnings"].to_string(), &words);
    let found = csv(run.out.join("modes.csv"));
    let zeros = [2.404825557695773, 5.520078110286311];
    for (row, zero) in found.iter().zip([zeros[0], zeros[0], zeros[1], zeros[1]]) {
        let exact = zero * f64::sqrt(9.81 / 3.0) / (2.0 * TAU);
        assert_close(row[1] / exact, 1.0, 1e-3, "frequency");
    }
    assert_eq!(found.len(), 4);
}

#[test]
fn settings_of_modes_are_checked() {
    check_table(
        &masses("[analysis.modes]\n"),
        refusal,
        r#"
[analysis.modes] => &\ncount = 0 | 0 | count
 => &\nnear = -1.0 | -1.0 | near
 => &\nrange = [2, 1] | [2, 1] | range = [2, 1] is out of range
 => &\nnear = 1.0\nrange = [1, 2] | | near
 => &\ncount = 3\nrange = [1, 2] | | count
 => &\nafter = { modes = {} } | | modes
 => &\nnumber = 3 | number | number
 => [analysis.buckling]\nafter = { dynamic = { to = 1, step = 0.1 } } | dynamic | unknown key or word `dynamic`
"#,
    );
}

/// A pinned column of elements of order one with EA = GA: 4 EI/h² tan²(πh/2L). More of the file.
fn column(more: &str) -> String {
    line(COLUMN, 8, 1, &[PINNED, more].concat())
}

#[test]
fn critical_loads_of_a_column() {
    for after in ["", "after = { static = { to = 4.0 } }"] {
        let text = column(&format!("[analysis.buckling]\ncount = 2\n{after}\n"));
        let out = run_of("buckling", &text).out;
        let rows = csv(out.join("buckling.csv"));
        for (row, EI) in rows.iter().zip([1.0, 3.0]) {
            let exact = 256.0 * EI * (PI / 16.0).tan().powi(2);
            assert!((row[1] / exact - 1.0).abs() < 1e-6, "{row:?} {exact}");
        }
        assert!(rows.len() == 2 && out.join("mode_02.svg").is_file());
    }
}

#[test]
fn matrices_at_the_end_of_a_path_that_does_not_end() {
    let path = column("[analysis.arc_length]\nmax_steps = 1\n");
    let ran = command("linearize", &[&write(&directory("no end"), &path)]);
    assert_says(&ended(&ran, 1), &["within max_steps = 1"]);
}

#[test]
fn matrices_of_two_masses() {
    let out = directory("matrices");
    let model = write(&out, &masses("[analysis.modes]\n"));
    succeeded(&command("linearize", &[&model]));
    for (name, known) in [
        ("K.mtx", [3.0, -1.0, -1.0, 1.0]),
        ("M.mtx", [3.0, 0.0, 0.0, 1.0]),
        ("C.mtx", [0.0; 4]),
    ] {
        let found = matrix(&out.join("model.linear").join(name));
        assert_eq!(found, DMatrix::from_row_slice(2, 2, &known));
    }
    let names = ["a", "b"].map(|node| format!("node {node}, displacement along e1\n"));
    let found = read(out.join("model.linear/coordinates.txt"));
    assert_eq!(found, names.concat());
}

/// A mass of 2 on springs of 8 across a shaft, at the speed 2: in the frame that rotates K = 8 − 2·2², C = ∓2·2·2.
#[test]
fn matrices_of_a_steady_rotation() {
    let slider = |name: &str, parent: &str, axis: &str| {
        let keys = format!("axis = {axis}\nspring = {{ k = 8 }}");
        joint(name, "prismatic", parent, &keys)
    };
    let text = [
        GROUND,
        &joint("S", "revolute", "ground", "axis = [0, 0, 1]"),
        &slider("X", "S", "[1, 0, 0]"),
        &slider("Y", "X", "[0, 1, 0]"),
        &body_of("Y", 2.0, ""),
        "[analysis.campbell]\njoint = \"S\"\nfrom = 1\nto = 2\nsteps = 1\n",
    ]
    .concat();
    let out = directory("rotating matrices");
    succeeded(&command("linearize", &[&write(&out, &text)]));
    for (name, known) in [("K.mtx", [0.0; 4]), ("C.mtx", [0.0, -8.0, 8.0, 0.0])] {
        let found = matrix(&out.join("model.linear").join(name));
        let gap = found - DMatrix::from_row_slice(2, 2, &known);
        assert!(gap.amax() < 1e-12, "{name}: {gap}");
    }
}

#[test]
fn matrices_of_a_motion_are_those_of_an_instant() {
    let started = "[[initial]]\nnode = \"a\"\nvelocity = [1, 0, 0]\n";
    let model = masses(&[started, &motion(0.1, 0.01)].concat());
    let model = write(&directory("moving matrices"), &model);
    let said = succeeded(&command("linearize", &[&model]));
    assert_says(&said, &["warning: the state moves"]);
}

#[test]
fn what_rests_to_rounding_errors_does_not_move() {
    // After a motion that begins in equilibrium, and after statics, whose prescribed functions have no rates.
    let swing = |after: &str, prescribed: &str| {
        [
            GROUND,
            &joint(
                "base",
                "revolute",
                "ground",
                &format!("axis = [0, 1, 0]\n{prescribed}"),
            ),
            &joint(
                "hinge",
                "revolute",
                "base",
                "axis = [0, 1, 0]\nspring = { k = 30 }",
            ),
            &arm("bob", "hinge", [2.0, 0.0, 0.0]),
            &body_of("bob", 3.0, ""),
            GRAVITY,
            &format!("[analysis.modes]\ncount = 1\n[analysis.modes.after.{after}]\n"),
        ]
        .concat()
    };
    let rest = "dynamic]\nto = 0.1\nstep = 0.01\nfrom_equilibrium = true\n[output";
    let still = "prescribed = { constant = 0.3 }";
    for text in [
        swing(rest, still),
        swing("static", "prescribed = { proportional = 0.3 }"),
    ] {
        let [_, warnings] = told("modes_at_rest", &text);
        assert!(warnings.is_empty(), "{warnings:?}");
    }
}

/// The frequency of a pendulum is that of its weight, which acts without a `time`; one that grows with the load is zero.
#[test]
fn loads_act_in_full_about_a_state_of_modes() {
    for (time, exact) in [
        ("", f64::sqrt(9.81 / 2.0) / TAU),
        ("time = { proportional = 1 }", 0.0),
    ] {
        let text = [
            GROUND,
            &joint("hinge", "revolute", "ground", "axis = [0, 1, 0]"),
            &arm("bob", "hinge", [0.0, 0.0, -2.0]),
            &body_of("bob", 3.0, ""),
            GRAVITY,
            time,
            "\n[analysis.modes]\ncount = 1\n",
        ];
        let out = ran(&directory("modes_of_a_pendulum"), &text.concat());
        let found = csv(out.join("modes.csv"))[0][1];
        assert!((found - exact).abs() < 1e-12, "{time}: {found}");
    }
}
