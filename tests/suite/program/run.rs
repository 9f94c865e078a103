//! A run of a small model writes what docs/model_file.md says.
#![allow(clippy::unwrap_used, non_snake_case)]

use crate::support::program::{
    MODEL, directory, ended, files, grid_array, history, number, program, read, results, succeeded,
    with, write,
};
use nalgebra::{Rotation3, Vector3};
use pullback::output::{COLUMNS, STATIC_COLUMNS};
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Command, Stdio};

#[test]
fn a_run_writes_all_its_files() {
    let directory = directory("program_run");
    let model = write(&directory, MODEL);
    let output = program(&[&model]);
    succeeded(&output);
    let out = directory.join("model.out");
    let expected = [
        "deformed.html",
        "deformed.svg",
        "history.csv",
        "history.svg",
        "result.json",
        "step_0000.vtu",
        "step_0001.vtu",
        "step_0002.vtu",
        "step_0003.vtu",
        "step_0004.vtu",
        "steps.pvd",
    ];
    assert_eq!(files(&out), expected, "and no temporary ones");

    // The columns documented, and values that follow from the statics of a pure moment: a
    // quarter of a circle of radius R = 2L/π that is inscribed by the polygon of 8 elements.
    let head = read(out.join("history.csv"))
        .lines()
        .next()
        .unwrap()
        .to_owned();
    let probes = "tip.x,tip.y,tip.z,turn,clamp,bending";
    assert_eq!(
        head,
        format!(
            "{},{},{probes}",
            COLUMNS.join(","),
            STATIC_COLUMNS.join(",")
        )
    );
    let reference = read(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/model_file.md"));
    for column in COLUMNS.iter().chain(&STATIC_COLUMNS) {
        assert!(
            reference.contains(&format!("| `{column}` |")),
            "{column} is not documented"
        );
    }
    let rows = history(&out);
    assert_eq!(rows.len(), 5);
    for (k, row) in rows.iter().enumerate() {
        let t = 0.25 * k as f64;
        assert_eq!(row["row"], k.to_string());
        assert_eq!(row["step"], k.to_string());
        assert!((number(row, "t") - t).abs() < 1e-12);
        assert!((number(row, "turn") - t * PI / 2.0).abs() < 1e-9);
        assert!((number(row, "largest_rotation") - t * PI / 2.0).abs() < 1e-9);
        assert!((number(row, "clamp") + t * PI).abs() < 1e-7);
        assert!((number(row, "bending") - t * PI).abs() < 1e-7);
        // ½ M φ.
        assert!((number(row, "strain_energy") - 0.5 * t * t * PI * PI / 2.0).abs() < 1e-6);
        assert!(number(row, "residual_over_tolerance") <= 1.0);
        assert_eq!(number(row, "chart_changes"), 0.0);
    }
    // Eight chords of length 1/8 at (k + ½) π/16.
    let chord = |k: i32| (f64::from(k) + 0.5) * PI / 16.0;
    let x: f64 = (0..8).map(|k| chord(k).cos() / 8.0).sum();
    assert!((number(&rows[4], "tip.x") - (x - 1.0)).abs() < 1e-9);
    assert!((number(&rows[4], "tip.y") - x).abs() < 1e-9);

    let results = results(&out);
    assert_eq!(results["complete"], true);
    assert_eq!(results["ending"]["kind"], "complete");
    assert_eq!(results["statistics"]["unknowns"], 48);
    assert_eq!(results["statistics"]["steps"], 4);
    assert_eq!(results["statistics"]["symmetric"], false);
    let moment = results["last"]["reactions"]["A"]["moment"][2]
        .as_f64()
        .unwrap();
    assert!((moment + PI).abs() < 1e-7);
    assert_eq!(results["last"]["nodes"].as_object().unwrap().len(), 9);
    let elements = results["last"]["elements"].as_object().unwrap();
    assert_eq!(elements.len(), 8);
    for (name, element) in elements {
        // The applied moment everywhere, and no force.
        let part = |what: &str, k: usize| element[what][k].as_f64().unwrap();
        assert!((part("M", 2) - PI).abs() < 1e-8, "{name}: {element}");
        let others = [0, 1, 2].map(|k| part("N", k)).into_iter();
        let others = others.chain([part("M", 0), part("M", 1)]);
        others.for_each(|x| assert!(x.abs() < 1e-6, "{name}: {element}"));
    }
    assert_eq!(results["settings"]["analysis"]["static"]["to"], 1.0);

    for name in expected
        .iter()
        .filter(|n| !n.ends_with("csv") && !n.ends_with("json") && !n.ends_with("html"))
    {
        let text = read(out.join(name));
        let document = roxmltree::Document::parse(&text).unwrap();
        if name.ends_with(".vtu") {
            check_grid(&document);
            check_circle(&document);
        }
    }
    let text = read(out.join("steps.pvd"));
    let document = roxmltree::Document::parse(&text).unwrap();
    let sets: Vec<_> = document
        .descendants()
        .filter(|n| n.has_tag_name("DataSet"))
        .collect();
    assert_eq!(sets.len(), 5);
    assert!(
        sets.iter()
            .all(|s| out.join(s.attribute("file").unwrap()).is_file())
    );
}

/// Vectors of an array of a grid.
fn vectors(document: &roxmltree::Document<'_>, name: &str) -> Vec<Vector3<f64>> {
    let numbers = grid_array(document, name);
    numbers.chunks(3).map(Vector3::from_column_slice).collect()
}

#[track_caller]
fn near(name: &str, found: &Vector3<f64>, exact: Vector3<f64>, tolerance: f64) {
    assert!(
        (found - exact).norm() <= tolerance,
        "{name}: {found:?} instead of {exact:?}"
    );
}

/// Values of the grid of the beam of [`MODEL`] under the end moment t π: EI = 2, L = 1, so that it
/// bends by φ = t π/2 into a circle of the radius 1/φ.
fn check_circle(document: &roxmltree::Document<'_>) {
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
    let directory = directory("program_forces");
    let model = write(
        &directory,
        &with(
            "moment = [0, 0, 3.141592653589793]",
            "force = [-0.4, 1.5, 0]",
        ),
    );
    assert!(program(&[&model]).status.success());
    let text = read(directory.join("model.out/step_0004.vtu"));
    let document = roxmltree::Document::parse(&text).unwrap();
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

/// Lengths of all arrays of a grid of 9 points and 8 cells; section axes orthonormal.
fn check_grid(document: &roxmltree::Document<'_>) {
    let piece = document
        .descendants()
        .find(|n| n.has_tag_name("Piece"))
        .unwrap();
    assert_eq!(piece.attribute("NumberOfPoints"), Some("9"));
    assert_eq!(piece.attribute("NumberOfCells"), Some("8"));
    let array = |name: &str| grid_array(document, name);
    for (name, length) in [
        ("Points", 27),
        ("displacement", 27),
        ("rotation", 27),
        ("connectivity", 16),
        ("offsets", 8),
        ("types", 8),
        ("N", 24),
        ("M", 24),
        ("Gamma", 24),
        ("K", 24),
        ("line", 8),
    ] {
        assert_eq!(array(name).len(), length, "{name}");
    }
    let axes = ["e1", "e2", "e3"].map(array);
    for p in 0..9 {
        for (i, a) in axes.iter().enumerate() {
            for (j, b) in axes.iter().enumerate() {
                let dot: f64 = (0..3).map(|k| a[3 * p + k] * b[3 * p + k]).sum();
                assert!((dot - f64::from(u8::from(i == j))).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn a_new_run_removes_the_steps_of_the_last_one_and_nothing_else() {
    let directory = directory("program_again");
    let model = write(&directory, MODEL);
    let out = directory.join("model.out");
    assert!(program(&[&model]).status.success());
    std::fs::write(out.join("notes.txt"), "mine").unwrap();
    write(&directory, &with("steps = 4", "steps = 2"));
    assert!(program(&[&model]).status.success());
    assert!(!out.join("step_0003.vtu").exists());
    assert!(out.join("step_0002.vtu").exists());
    assert_eq!(read(out.join("notes.txt")), "mine");
    // A directory that holds no results is not tidied.
    let other = directory.join("other");
    std::fs::create_dir(&other).unwrap();
    std::fs::write(other.join("step_9999.vtu"), "mine").unwrap();
    assert!(
        program(&[&model, Path::new("--out"), &other])
            .status
            .success()
    );
    assert_eq!(read(other.join("step_9999.vtu")), "mine");
}

#[test]
fn a_refused_file_shows_the_place_and_writes_nothing() {
    let directory = directory("program_refused");
    let model = write(&directory, &with("to = \"B\"", "to = \"C\""));
    let output = program(&[&model]);
    let said = ended(&output, 2);
    for part in [
        "no node named \"C\"",
        "model.toml:13:6",
        "to = \"C\"",
        "`A`, `B`",
    ] {
        assert!(said.contains(part), "{part:?} is not in\n{said}");
    }
    assert_eq!(files(&directory), ["model.toml"]);
}

#[test]
fn results_that_cannot_be_written_are_an_error() {
    let directory = directory("program_unwritable");
    let model = write(&directory, MODEL);
    let file = directory.join("file");
    std::fs::write(&file, "in the way").unwrap();
    let output = program(&[&model, Path::new("--out"), &file]);
    let said = ended(&output, 2);
    assert!(said.contains("cannot write"), "{said}");
}

#[test]
fn nobody_has_to_listen() {
    // A joint is a note on standard output, and that nothing moves a warning on standard error.
    let directory = directory("program_closed");
    let joint = "\n[[joints]]\nname = \"pin\"\ntype = \"revolute\"\nparent = \"B\"\naxis = [0, 0, 1]\n\
                 spring = { k = 1 }\n";
    let model = write(&directory, &(with("3.141592653589793", "0") + joint));
    let run = |file: &Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pullback"));
        command.arg("run").arg(file);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().unwrap()
    };
    let heard = run(&model).wait_with_output().unwrap();
    assert!(heard.stdout.starts_with(b"degrees of freedom"));
    assert!(heard.stderr.starts_with(b"warning"));
    for (file, code) in [(&model, 0), (&directory.join("none.toml"), 2)] {
        let mut child = run(file);
        drop((child.stdout.take(), child.stderr.take()));
        assert_eq!(child.wait().unwrap().code(), Some(code));
    }
}

#[test]
fn two_runs_do_not_write_into_one_directory() {
    let directory = directory("program_two");
    let model = write(&directory, MODEL);
    let mut said = String::new();
    let outcome = pullback::run::run(&model, None, &mut |step| {
        if step.number == 1 {
            let other = program(&[&model]);
            assert_eq!(other.status.code(), Some(2));
            said = String::from_utf8(other.stderr).unwrap();
        }
        ControlFlow::Continue(())
    });
    let process = format!("process {} is writing there", std::process::id());
    assert!(said.contains(&process), "{said}");
    assert_eq!(outcome.unwrap().rows, 5);
    // The claim ends with the run.
    assert!(program(&[&model]).status.success());
    assert!(!files(&directory.join("model.out")).contains(&".lock".to_owned()));
}

#[test]
fn quiet_is_quiet_and_figures_can_be_left_out() {
    let directory = directory("program_quiet");
    let model = write(
        &directory,
        &(MODEL.to_owned() + "\n[output]\nfigures = false\nparaview_every = 3\n"),
    );
    let output = program(&[&model, Path::new("--quiet")]);
    assert!(output.status.success());
    assert!(output.stdout.is_empty() && output.stderr.is_empty());
    let expected = [
        "history.csv",
        "result.json",
        "step_0000.vtu",
        "step_0003.vtu",
        "step_0004.vtu",
        "steps.pvd",
    ];
    assert_eq!(files(&directory.join("model.out")), expected);
}

#[test]
fn paths_record_their_events() {
    // A moment bends the beam along; its tip passes a quarter of a turn at full load.
    let analysis = "[analysis.arc_length]\nstop = [{ coordinate = { node = \"B\", dof = \"rz\", value = 1.5 } }]\nrecord = [{ load = 0.5 }]";
    let directory = directory("program_path");
    let model = write(&directory, &with("[analysis.static]\nsteps = 4", analysis));
    let output = program(&[&model]);
    succeeded(&output);
    let rows = history(&directory.join("model.out"));
    let half = rows.iter().find(|r| r["event"] == "load = 0.5").unwrap();
    assert!((number(half, "t") - 0.5).abs() < 1e-9);
    assert!((number(half, "turn") - PI / 4.0).abs() < 1e-8);
    let last = rows.last().unwrap();
    assert_eq!(last["event"], "rz of B = 1.5");
    assert!((number(last, "turn") - 1.5).abs() < 1e-9);
    assert!((number(last, "t") - 3.0 / PI).abs() < 1e-8);

    // Too few steps to get there.
    let short = analysis.replace(
        "[analysis.arc_length]",
        "[analysis.arc_length]\nmax_steps = 2",
    );
    write(&directory, &with("[analysis.static]\nsteps = 4", &short));
    let output = program(&[&model]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("max_steps = 2"));
    assert_eq!(
        results(&directory.join("model.out"))["ending"]["kind"],
        "step_limit"
    );
}

/// Rods one beside the other, with what a file can say about each.
fn many(count: usize) -> String {
    let section = "[sections]\ns = { stiffness = { EA = 1e3, GA = [1e3, 1e3], GJ = 1, EI = [1, 1] }, \
                   mass = { A_rho = 1, J = [2, 1, 1] } }\n";
    let mut nodes = String::from("[nodes]\n");
    let mut parts = String::new();
    for k in 0..count {
        nodes += &format!("a{k} = [0, {k}, 0]\nb{k} = [1, {k}, 0]\nc{k} = [2, {k}, 0]\n");
        parts += &format!(
            r#"
            [[lines]]
            name = "l{k}"
            from = "a{k}"
            to = "b{k}"
            elements = 1
            section = "s"
            [[joints]]
            name = "j{k}"
            type = "revolute"
            parent = "b{k}"
            axis = [0, 0, 1]
            value = 0.1
            [[bodies]]
            name = "m{k}"
            node = "c{k}"
            mass = 1
            [[springs]]
            name = "k{k}"
            nodes = ["b{k}", "c{k}"]
            stiffness = 1
            [[bodies]]
            name = "n{k}"
            node = "j{k}"
            mass = 1
            inertia = [1, 1, 1]
            [[supports]]
            node = "a{k}"
            fix = "all"
            [[loads]]
            line = "l{k}"
            force_per_length = [0, 0, 1]
            [[initial]]
            node = "b{k}"
            velocity = [0, 0, 1]
            [[probes]]
            name = "p{k}"
            quantity = "reaction_force"
            node = "a{k}"
            "#
        );
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
        let time = || {
            let start = std::time::Instant::now();
            let output = program(&[&model]);
            assert!(output.status.success(), "{output:?}");
            start.elapsed().as_secs_f64()
        };
        (0..2).map(|_| time()).fold(f64::INFINITY, f64::min)
    };
    let growth = seconds(3200) / seconds(200);
    assert!(growth < 48.0, "{growth}");
}
