//! A run of a small model writes what docs/model_file.md says.

use crate::support::drawings::tagged;
use crate::support::*;
use nalgebra::{Rotation3, Vector3};
use pullback::output::{COLUMNS, STATIC_COLUMNS};
use roxmltree::Document;
use serde_json::Value;
use std::collections::HashMap;
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::path::Path;

#[test]
fn a_run_writes_all_its_files() {
    let run = run_of("program_run", MODEL);
    let steps: Vec<String> = (0..5).map(|k| format!("step_000{k}.vtu")).collect();
    let drawn = "deformed.html deformed.svg history.csv history.svg result.json".split(' ');
    let expected = drawn
        .chain(steps.iter().map(|s| &s[..]))
        .chain(["steps.pvd"]);
    assert!(files(&run.out).iter().eq(expected), "and no temporary ones");
    let head = read(run.out.join("history.csv"));
    let columns = [COLUMNS.as_slice(), &STATIC_COLUMNS];
    let expected = columns.concat().join(",") + ",tip.x,tip.y,tip.z,turn,clamp,bending";
    assert_eq!(head.lines().next(), Some(&expected[..]));
    let reference = read(repository("docs/model_file.md"));
    for column in columns.concat() {
        assert_says(&reference, &[&format!("| `{column}` |")]);
    }
    check_rows(&run.rows);
    check_results(&run.result);
    for name in steps {
        let text = read(run.out.join(name));
        let document = Document::parse(&text).unwrap();
        check_grid(&document);
        check_circle(&document);
    }
    for name in ["deformed.svg", "history.svg"] {
        Document::parse(&read(run.out.join(name))).unwrap();
    }
    let text = read(run.out.join("steps.pvd"));
    let document = Document::parse(&text).unwrap();
    let sets = tagged(&document, "DataSet").map(|set| set.attribute("file").unwrap());
    let sets: Vec<&str> = sets.collect();
    assert_eq!(sets.len(), 5);
    assert!(sets.iter().all(|file| run.out.join(file).is_file()));
}

/// Values that follow from the statics of a pure moment: a quarter of a circle of radius R = 2L/π that is
/// inscribed by the polygon of 8 elements.
fn check_rows(rows: &[HashMap<String, String>]) {
    assert_eq!(rows.len(), 5);
    for (k, row) in rows.iter().enumerate() {
        let t = 0.25 * k as f64;
        assert_eq!([&row["row"], &row["step"]], [&k.to_string(); 2]);
        for (column, exact, within) in [
            ("t", t, 1e-12),
            ("turn", t * PI / 2.0, 1e-9),
            ("largest_rotation", t * PI / 2.0, 1e-9),
            ("clamp", -t * PI, 1e-7),
            ("bending", t * PI, 1e-7),
            // ½ M φ.
            ("strain_energy", 0.5 * t * t * PI * PI / 2.0, 1e-6),
        ] {
            assert_close(number(row, column), exact, within, column);
        }
        assert!(number(row, "residual_over_tolerance") <= 1.0);
        assert_eq!(number(row, "chart_changes"), 0.0);
    }
    // Eight chords of length 1/8 at (k + ½) π/16.
    let chord = |k: i32| (f64::from(k) + 0.5) * PI / 16.0;
    let x: f64 = (0..8).map(|k| chord(k).cos() / 8.0).sum();
    assert_close(number(&rows[4], "tip.x"), x - 1.0, 1e-9, "tip");
    assert_close(number(&rows[4], "tip.y"), x, 1e-9, "tip");
}

fn check_results(result: &Value) {
    assert_eq!(result["complete"], true);
    assert_eq!(result["ending"]["kind"], "complete");
    let statistics = &result["statistics"];
    assert_eq!(statistics["unknowns"], 48);
    assert_eq!(statistics["steps"], 4);
    assert_eq!(statistics["symmetric"], false);
    assert_eq!(result["settings"]["analysis"]["static"]["to"], 1.0);
    let last = &result["last"];
    let moment = last["reactions"]["A"]["moment"][2].as_f64().unwrap();
    assert_close(moment, -PI, 1e-7, "reaction");
    assert_eq!(last["nodes"].as_object().unwrap().len(), 9);
    let elements = last["elements"].as_object().unwrap();
    assert_eq!(elements.len(), 8);
    for (name, element) in elements {
        // The applied moment everywhere, and no force.
        let part = |what: &str, k: usize| element[what][k].as_f64().unwrap();
        assert_close(part("M", 2), PI, 1e-8, name);
        for (what, k) in [("N", 0), ("N", 1), ("N", 2), ("M", 0), ("M", 1)] {
            assert_close(part(what, k), 0.0, 1e-6, format!("{name}, {what}"));
        }
    }
}

/// Vectors of an array of a grid.
fn vectors(document: &Document<'_>, name: &str) -> Vec<Vector3<f64>> {
    let numbers = grid_array(document, name);
    numbers.chunks(3).map(Vector3::from_column_slice).collect()
}

#[track_caller]
fn near(name: &str, found: &Vector3<f64>, exact: Vector3<f64>, tolerance: f64) {
    let off = (found - exact).norm();
    assert!(off <= tolerance, "{name}: {found:?} {exact:?}");
}

/// Values of the grid of the beam of [`MODEL`] under the end moment t π: EI = 2, L = 1, so that it
/// bends by φ = t π/2 into a circle of the radius 1/φ.
fn check_circle(document: &Document<'_>) {
    let t = grid_array(document, "load_parameter")[0];
    let phi = t * PI / 2.0;
    // Section forces and strains of every element: bending alone.
    for (name, exact, tolerance) in [
        ("N", Vector3::zeros(), 1e-7),
        ("M", Vector3::new(0.0, 0.0, t * PI), 1e-8),
        ("Gamma", Vector3::zeros(), 1e-12),
        ("K", Vector3::new(0.0, 0.0, phi), 1e-8),
    ] {
        for value in vectors(document, name) {
            near(name, &value, exact, tolerance);
        }
    }
    // Nodes of elements that stay straight lie on a circle with chords of their length, wider than
    // the exact one by (φ/16)²/6 of it, the error of the mesh.
    let half = phi / 16.0;
    let wider = if t > 0.0 { half / half.sin() } else { 1.0 };
    let mesh = 1.01 * half * half / 6.0;
    let names = ["displacement", "Points", "rotation", "e1", "e2", "e3"];
    let found = names.map(|name| vectors(document, name));
    for k in 0..9 {
        let s = k as f64 / 8.0;
        let (sin, cos) = (s * phi).sin_cos();
        // (sin sφ, 1 − cos sφ)/φ.
        let circle = match t {
            0.0 => Vector3::new(s, 0.0, 0.0),
            _ => Vector3::new(sin, 1.0 - cos, 0.0) / phi,
        };
        near("Points", &found[1][k], circle, mesh * s + 1e-9);
        let position = circle * wider;
        let exact = [
            position - Vector3::new(s, 0.0, 0.0),
            position,
            Vector3::new(0.0, 0.0, s * phi),
            Vector3::new(cos, sin, 0.0),
            Vector3::new(-sin, cos, 0.0),
            Vector3::z(),
        ];
        for ((name, values), exact) in names.iter().zip(&found).zip(exact) {
            near(name, &values[k], exact, 1e-8);
        }
    }
}

#[test]
fn section_forces_of_the_grid_are_in_the_axes_of_the_section() {
    // With a dead force alone at the tip equilibrium gives them in every element, however far it has
    // turned: N = Rᵀ F and M = Rᵀ (x_tip − x) × F in its middle.
    let force = Vector3::new(-0.4, 1.5, 0.0);
    let loaded = with(
        "moment = [0, 0, 3.141592653589793]",
        "force = [-0.4, 1.5, 0]",
    );
    let out = ran(&directory("program_forces"), &loaded);
    let text = read(out.join("step_0004.vtu"));
    let document = Document::parse(&text).unwrap();
    let [x, turn, N, M] = ["Points", "rotation", "N", "M"].map(|name| vectors(&document, name));
    assert!(turn[8].z > 0.3, "it has turned: {}", turn[8]);
    for e in 0..8 {
        let middle = (x[e] + x[e + 1]) / 2.0;
        let R = Rotation3::new((turn[e] + turn[e + 1]) / 2.0);
        near("N", &N[e], R.inverse() * force, 1e-7);
        let moment = R.inverse() * (x[8] - middle).cross(&force);
        near("M", &M[e], moment, 1e-7);
    }
}

/// Lengths of all arrays of a grid of 9 points and 8 cells.
fn check_grid(document: &Document<'_>) {
    let piece = tagged(document, "Piece").next().unwrap();
    assert_eq!(piece.attribute("NumberOfPoints"), Some("9"));
    assert_eq!(piece.attribute("NumberOfCells"), Some("8"));
    for (names, length) in [
        ("Points displacement rotation", 27),
        ("N M Gamma K", 24),
        ("connectivity", 16),
        ("offsets types line", 8),
    ] {
        for name in names.split(' ') {
            assert_eq!(grid_array(document, name).len(), length, "{name}");
        }
    }
}

#[test]
fn a_new_run_removes_the_steps_of_the_last_one_and_nothing_else() {
    let directory = directory("program_again");
    let out = ran(&directory, MODEL);
    std::fs::write(out.join("notes.txt"), "mine").unwrap();
    ran(&directory, &with("steps = 4", "steps = 2"));
    assert!(!out.join("step_0003.vtu").exists());
    assert!(out.join("step_0002.vtu").exists());
    assert_eq!(read(out.join("notes.txt")), "mine");
    // A directory that holds no results is not tidied.
    let other = directory.join("other");
    std::fs::create_dir(&other).unwrap();
    std::fs::write(other.join("step_9999.vtu"), "mine").unwrap();
    let model = directory.join("model.toml");
    succeeded(&program(&[&model, Path::new("--out"), &other]));
    assert_eq!(read(other.join("step_9999.vtu")), "mine");
}

#[test]
fn a_refused_file_shows_the_place_and_writes_nothing() {
    let directory = directory("program_refused");
    write(&directory, &with("to = \"B\"", "to = \"C\""));
    for command in ["run", "check"] {
        let output = program_in(&directory, &format!("{command} model.toml"));
        let place = [
            "no node named \"C\"",
            "model.toml:10:6",
            "to = \"C\"",
            "`A`, `B`",
        ];
        assert_says(&ended(&output, 2), &place);
        assert!(output.stdout.is_empty(), "{command}");
    }
    assert_eq!(files(&directory), ["model.toml"]);
}

#[test]
fn nobody_has_to_listen() {
    // A joint is a note on standard output, and that nothing moves a warning on standard error.
    let joint = format!("\n{}", hinge("pin", "B", "spring = { k = 1 }"));
    let text = with("3.141592653589793", "0") + &joint;
    let model = write(&directory("program_closed"), &text);
    let heard = spawned(&["run"], &model).wait_with_output().unwrap();
    assert!(heard.stdout.starts_with(b"degrees of freedom"));
    assert!(heard.stderr.starts_with(b"warning"));
    for (file, code) in [(&model, 0), (&model.with_file_name("none.toml"), 2)] {
        let mut child = spawned(&["run"], file);
        drop((child.stdout.take(), child.stderr.take()));
        assert_eq!(child.wait().unwrap().code(), Some(code));
    }
}

#[test]
fn two_runs_do_not_write_into_one_directory() {
    let model = write(&directory("program_two"), MODEL);
    let mut said = String::new();
    let outcome = pullback::run::run(&model, None, &mut |step| {
        if step.number == 1 {
            said = ended(&program(&[&model]), 2);
        }
        ControlFlow::Continue(())
    });
    let process = format!("process {} is writing there", std::process::id());
    assert_says(&said, &[&process]);
    assert_eq!(outcome.unwrap().rows, 5);
    // The claim ends with the run.
    succeeded(&program(&[&model]));
    assert!(!files(&model.with_extension("out")).contains(&".lock".to_owned()));
}

#[test]
fn quiet_is_quiet_and_figures_can_be_left_out() {
    let output = "\n[output]\nfigures = false\nparaview_every = 3\n";
    let model = write(&directory("program_quiet"), &(MODEL.to_owned() + output));
    let output = program(&[&model, Path::new("--quiet")]);
    assert!(succeeded(&output).is_empty() && output.stdout.is_empty());
    let expected =
        "history.csv result.json step_0000.vtu step_0003.vtu step_0004.vtu steps.pvd".split(' ');
    assert!(files(&model.with_extension("out")).iter().eq(expected));
}

#[test]
fn paths_record_their_events() {
    // A moment bends the beam along; its tip passes a quarter of a turn at full load.
    let bent = |more: &str| {
        let stop = "stop = [{ coordinate = { node = \"B\", dof = \"rz\", value = 1.5 } }]";
        let path = format!("[analysis.arc_length]\n{more}{stop}\nrecord = [{{ load = 0.5 }}]");
        with("[analysis.static]\nsteps = 4", &path)
    };
    let rows = run_of("program_path", &bent("")).rows;
    let half = rows.iter().find(|r| r["event"] == "load = 0.5").unwrap();
    let last = rows.last().unwrap();
    assert_eq!(last["event"], "rz of B = 1.5");
    for (row, column, exact, within) in [
        (half, "t", 0.5, 1e-9),
        (half, "turn", PI / 4.0, 1e-8),
        (last, "turn", 1.5, 1e-9),
        (last, "t", 3.0 / PI, 1e-8),
    ] {
        assert_close(number(row, column), exact, within, &row["event"]);
    }
    // Too few steps to get there.
    let model = write(&directory("program_path"), &bent("max_steps = 2\n"));
    assert_says(&ended(&program(&[&model]), 1), &["max_steps = 2"]);
    let ending = &results(&model.with_extension("out"))["ending"];
    assert_eq!(ending["kind"], "step_limit");
}

/// Rods one beside the other, with what a file can say about each.
fn many(count: usize) -> String {
    let section = "[sections]\ns = { stiffness = { EA = 1e3, GA = [1e3, 1e3], GJ = 1, EI = [1, 1] }, \
                   mass = { A_rho = 1, J = [2, 1, 1] } }\n";
    let mut nodes = String::from("[nodes]\n");
    let mut parts = String::new();
    for k in 0..count {
        nodes += &format!("a{k} = [0, {k}, 0]\nb{k} = [1, {k}, 0]\nc{k} = [2, {k}, 0]\n");
        let [a, b, c, j] = ["a", "b", "c", "j"].map(|name| format!("{name}{k}"));
        parts += &[
            beam_line(&format!("l{k}"), [&a, &b], 1, "s"),
            hinge(&j, &b, "value = 0.1"),
            body_of(&c, 1.0, ""),
            body_of(&j, 1.0, "inertia = [1, 1, 1]"),
            fixed(&a),
            probe(&format!("p{k}"), "reaction_force", &a),
            format!("[[springs]]\nname = \"k{k}\"\nnodes = [\"{b}\", \"{c}\"]\nstiffness = 1\n"),
            format!("[[loads]]\nline = \"l{k}\"\nforce_per_length = [0, 0, 1]\n"),
            format!("[[initial]]\nnode = \"{b}\"\nvelocity = [0, 0, 1]\n"),
        ]
        .concat();
    }
    format!("{section}{nodes}{parts}\n[analysis]\ndynamic = {{ to = 1e-4, step = 1e-4 }}\n")
}

/// Sixteen times as many of everything take sixteen times as long, from the file to the results, where
/// one search among all for each takes 256 times as long.
#[test]
fn files_cost_what_they_say() {
    let directory = directory("program_growth");
    let seconds = |count: usize| {
        let model = write(&directory, &many(count));
        let start = std::time::Instant::now();
        succeeded(&program(&[&model]));
        start.elapsed().as_secs_f64()
    };
    let growth = seconds(3200) / seconds(200).min(seconds(200));
    assert!(growth < 48.0, "{growth}");
}
