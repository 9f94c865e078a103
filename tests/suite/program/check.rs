//! `pullback check`: every model of the gallery passes, and what it prints and returns.
#![allow(clippy::unwrap_used)]

use crate::support::closures::{
    CLOSURES, GROUND, RUN, STATIC, arm, body, five_bar, four_bar, hinge, joint,
};
use crate::support::program::{MODEL, command, directory, with, write};
use pullback::check;
use std::path::Path;

#[test]
fn all_models_of_the_gallery_pass() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models");
    let mut count = 0;
    for entry in std::fs::read_dir(models).unwrap() {
        let path = entry.unwrap().path();
        for seed in 0..2 {
            let mut job = pullback::input::load(&path).unwrap();
            let report = check::job(&mut job, seed);
            assert!(
                report.is_ok(),
                "{} with seed {seed}\n{}",
                path.display(),
                check::table(&report)
            );
        }
        count += 1;
    }
    assert!(count >= 25, "{count}");
}

/// Nothing is wrong in a model at the random states of some seeds.
#[track_caller]
fn assert_right(what: &str, text: &str, seeds: impl IntoIterator<Item = u64>) {
    for seed in seeds {
        let mut job = pullback::input::assemble_text(what, text).unwrap();
        let report = check::job(&mut job, seed);
        let table = check::table(&report);
        assert!(report.is_ok(), "{what}, seed {seed}\n{table}");
        assert!(report.rows().len() > 10, "{table}");
    }
}

fn run(arguments: &[&str]) -> (Option<i32>, String, String) {
    let words: Vec<&Path> = arguments.iter().map(Path::new).collect();
    let output = command("check", &words);
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (
        output.status.code(),
        text(output.stdout),
        text(output.stderr),
    )
}

#[test]
fn the_table_and_the_rows_of_a_model() {
    let directory = directory("program_check");
    let path = write(&directory, MODEL);
    let path = path.to_str().unwrap();
    // A line for each component by default.
    let (code, short, errors) = run(&[path]);
    assert_eq!((code, errors.as_str()), (Some(0), ""), "{short}");
    let beams: Vec<&str> = (short.lines())
        .filter(|l| l.starts_with("element beam:* (beam), 8 of them  "))
        .collect();
    assert_eq!(beams.len(), 1, "{short}");
    assert!(beams[0].contains(" (worst of "), "{short}");
    assert!(!short.contains("Beam<"), "{short}");
    let (code, table, errors) = run(&[path, "--all"]);
    assert_eq!((code, errors.as_str()), (Some(0), ""), "{table}");
    assert!(table.lines().count() > 2 * short.lines().count());
    for words in [
        "component",
        "K = -dr/dx",
        "element beam:* (beam), 8 of them",
        "load load 1",
        "10 components, 0 wrong",
    ] {
        assert!(table.contains(words), "{words}\n{table}");
    }
    let (code, json, _) = run(&[path, "--json", "--seed", "3"]);
    assert_eq!(code, Some(0));
    let rows: serde_json::Value = serde_json::from_str(&json).unwrap();
    let rows = rows.as_array().unwrap();
    assert!(rows.len() > 100, "{}", rows.len());
    for row in rows {
        assert_eq!(row["passed"], true, "{row}");
        assert!(
            row["value"].is_number() && row["limit"].is_number(),
            "{row}"
        );
    }
    let components = rows.iter().map(|r| r["component"].as_str().unwrap());
    assert!(components.clone().any(|c| c == "model"));
    assert!(components.clone().any(|c| c == "element beam:8 (beam)"));
}

#[test]
fn a_wrong_file_is_refused() {
    let directory = directory("program_check_wrong");
    let path = write(&directory, &with("from = \"A\"", "from = \"C\""));
    let (code, table, errors) = run(&[path.to_str().unwrap()]);
    assert_eq!((code, table.as_str()), (Some(2), ""));
    assert!(
        errors.contains("C") && errors.contains("model.toml"),
        "{errors}"
    );
}

#[test]
fn failures_are_told_one_by_one() {
    let mut report = check::Report::new("element pin (Pin)");
    report.defect("K symmetric", "start", 2.0, 1e-9);
    report.blame(|| {
        vec![check::Block {
            matrix: "K".to_owned(),
            rows: "rotation of node a".to_owned(),
            columns: "displacement of node b".to_owned(),
            defect: 2.0,
            right: 4.0,
            factor: 0.5,
        }]
    });
    let table = check::table(&report);
    for words in [
        "FAIL element pin (Pin): K symmetric",
        "K (rows: rotation of node a; columns: displacement of node b): off by 2.000e0",
        "it is 0.500 times what is right",
        "1 properties of 1 components, 1 wrong",
    ] {
        assert!(table.contains(words), "{words}\n{table}");
    }
    let entries = check::entries(&report);
    assert_eq!(entries[0]["passed"], false);
    assert_eq!(entries[0]["blocks"][0]["factor"], 0.5);
}

#[test]
fn a_mechanism_by_the_names_of_its_file() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models");
    let (code, said, _) = run(&[models.join("four_bar.toml").to_str().unwrap()]);
    assert_eq!(code, Some(0), "{said}");
    for words in [
        "joint C closes a loop; independent: A angle; redundant: ",
        "degrees of freedom: 1 of 4 coordinates, 1 loop with 6 equations, of which 3 are redundant",
        "joint A (revolute)",
        "joint crank tip (offset)",
        "coordinate B angle (in a loop)",
        "\ncoordinates of C (closed loop)",
        "element body crank (rigid body)",
    ] {
        assert!(said.contains(words), "{words}\n{said}");
    }
}

/// A bead on a beam, `start` from its beginning.
fn bead(start: f64) -> String {
    with(
        "[analysis",
        &format!(
            "[[joints]]\nname = \"bead\"\ntype = \"slide\"\nlines = [\"beam\"]\nstart = {start}\n\
             spring = {{ k = 1 }}\n\n[[loads]]\nnode = \"bead\"\nforce = [0, 0, -1]\n\n[analysis"
        ),
    )
}

#[test]
fn a_slide_may_start_at_the_end_of_its_chain() {
    for start in [0.0, 1.0] {
        assert_right(&format!("a start at {start}"), &bead(start), 0..3);
    }
}

/// A random state is on another line of its chain, with another corner, than the start.
#[test]
fn a_slide_may_start_near_a_node_of_its_chain() {
    for start in [0.37, 0.38] {
        assert_right(&format!("a start at {start}"), &bead(start), 0..6);
    }
}

/// The third derivative of a curve through points jumps at them, where a closed one starts by default.
#[test]
fn a_point_on_a_curve_may_start_at_a_point_that_it_leads_through() {
    for start in ["closed = true", "start = 1.0198039027185569"] {
        let model = format!(
            "[nodes]\nground = [0, 0, 0]\n\n[[joints]]\nname = \"p\"\ntype = \"on_curve\"\n\
             parent = \"ground\"\n{start}\n\
             through = [[-1, 0, 0.2], [0, 0, 0], [1, 0.3, 0], [2, 0, 0.1], [3, 0.5, 0]]\n\n\
             [[bodies]]\nname = \"b\"\nnode = \"p\"\nmass = 1\ninertia = [0.1, 0.1, 0.1]\n\n\
             [[supports]]\nnode = \"ground\"\nfix = \"all\"\n\n\
             [[loads]]\ngravity = [0, 0, -9.81]\n\n[analysis.dynamic]\nto = 0.1\nstep = 0.01\n"
        );
        assert_right(start, &model, 0..6);
    }
}

/// Where a joint of a loop is driven, what its drive does at a state that is out of balance depends on
/// which coordinates are free: only with what is out of balance it is the power that stays.
#[test]
fn a_driven_joint_of_a_loop_may_have_other_coordinates_beside_it() {
    let driven = "prescribed = { sine = { amplitude = 0.5, omega = 3 } }";
    let model = [
        &*five_bar([driven, "", ""]),
        &body("B"),
        &body("D").replace("mass", "center = [0.5, 0, 0]\nmass"),
        "[[loads]]\ngravity = [-9.81, 0, 0]\n",
    ]
    .concat();
    assert_right("five bars", &model, 0..60);
}

/// Two rigid links from the coupler of a linkage to the same frame, one of them by a stiff penalty:
/// what it does cancels, and leaves its round-off in the tangent.
#[test]
fn a_redundant_rigid_link_by_a_penalty_is_no_error() {
    let link = r#"[[joints]]
name = "link"
type = "offset"
parent = "B"
position = [0.5, 1.5, 0]

[[joints]]
name = "again"
type = "offset"
parent = "link"
position = [1.2, 1.9, 0]
child = "coupler tip"
closure = "penalty"
penalty = 1e9
penalty_damping = 1e-3

[[bodies]]"#;
    let text =
        include_str!("../../../examples/models/four_bar.toml").replacen("[[bodies]]", link, 1);
    assert_right("four bars", &text, 0..13);
}

/// A ring of bars of unit length and spherical joints in the plane, from the ground to the ground.
fn ring(bars: u32) -> String {
    let mut text = String::from("[nodes]\nground = [0, 0, 0]\n");
    let turn = std::f64::consts::TAU / f64::from(bars);
    let (mut x, mut y, mut parent) = (0.0, 0.0, "ground".to_owned());
    for k in 0..bars {
        let (s, c) = (turn * (f64::from(k) + 0.5)).sin_cos();
        let (next_x, next_y) = match k + 1 == bars {
            true => (0.0, 0.0),
            false => (x + c, y + s),
        };
        let middle = [0.5 * (x + next_x), 0.5 * (y + next_y)];
        text += &format!(
            "[[joints]]\nname = \"j{k}\"\ntype = \"spherical\"\nparent = \"{parent}\"\n\
             [[joints]]\nname = \"o{k}\"\ntype = \"offset\"\nparent = \"j{k}\"\n\
             position = [{next_x:?}, {next_y:?}, 0]\n\
             [[bodies]]\nname = \"b{k}\"\nnode = \"j{k}\"\nmass = 1\n\
             center = [{:?}, {:?}, 0]\ninertia = [0.1, 0.2, 0.15]\n",
            middle[0], middle[1],
        );
        (x, y, parent) = (next_x, next_y, format!("o{k}"));
    }
    text + "[[joints]]\nname = \"close\"\ntype = \"spherical\"\nchild = \"ground\"\nparent = \""
        + &parent
        + "\"\n[[supports]]\nnode = \"ground\"\nfix = \"all\"\n\
           [[loads]]\ngravity = [0, -9.81, -2]\n[analysis.dynamic]\nto = 1\nstep = 0.002\n"
}

#[test]
fn rings_of_bars_that_nothing_keeps_from_spinning_are_right() {
    // About its line a bar has no stiffness: what stands there are the last digits of what cancels.
    for bars in [3, 4, 5, 8] {
        assert_right(&format!("{bars} bars"), &ring(bars), 0..3);
    }
}

/// A crank and a rocker on skew axes, between them a bar on two balls with its mass on its axis: nothing acts on
/// its spin, while forces that are not small cancel in it.
#[test]
fn a_bar_that_may_spin_between_two_balls_is_right() {
    let model = [
        GROUND,
        RUN,
        &hinge("A", "ground", ""),
        &arm("crank tip", "A", [0.5, 0.0, 0.0]),
        &joint("S1", "spherical", "crank tip", ""),
        &arm("coupler tip", "S1", [1.5, 0.4, 0.9]),
        &arm("mid", "S1", [1.0, 0.2, 0.45]),
        &arm("foot", "ground", [1.5, 0.4, 0.0]),
        &joint("D", "revolute", "foot", "axis = [1, 0, 0]"),
        &arm("rocker tip", "D", [1.5, 0.4, 0.9]),
        &joint("S2", "spherical", "coupler tip", "child = \"rocker tip\""),
        &body("mid"),
        &body("D"),
        "[[loads]]\ngravity = [0, 0, -9.81]\n",
    ]
    .concat();
    assert_right("a bar", &model, 0..7);
}

/// Stephenson's linkage: a driven four-bar, and a second loop on its coupler, each closed in its own way.
#[test]
fn loops_that_are_closed_in_two_ways_are_checked_where_they_can_be() {
    let driven = "prescribed = { sine = { amplitude = 0.35, omega = 3 } }";
    let linkage = |first: &str, second: &str| {
        [
            GROUND,
            "[analysis.dynamic]\nto = 2.2\nstep = 0.002\nscheme = { generalised-alpha = 0.8 }\n",
            &hinge("A", "ground", driven),
            &arm("a", "A", [0.0, 1.0, 0.0]),
            &hinge("B", "a", ""),
            &arm("b", "B", [2.987, 2.824, 0.0]),
            &arm("p", "B", [1.077, 2.595, 0.0]),
            &arm("foot", "ground", [4.0, 0.0, 0.0]),
            &hinge("D", "foot", ""),
            &arm("d", "D", [2.987, 2.824, 0.0]),
            &hinge("C", "b", &format!("child = \"d\"\n{first}")),
            &hinge("P", "p", ""),
            &arm("e", "P", [3.76, 4.995, 0.0]),
            &arm("foot 2", "ground", [6.0, 3.0, 0.0]),
            &hinge("F", "foot 2", ""),
            &arm("f", "F", [3.76, 4.995, 0.0]),
            &hinge("E", "e", &format!("child = \"f\"\n{second}")),
            &body("b"),
            &body("d"),
            &body("e"),
            &body("f"),
        ]
        .concat()
    };
    for first in CLOSURES {
        for second in [CLOSURES[0], CLOSURES[1]] {
            let what = format!("{first}, {second}");
            assert_right(&what, &linkage(first, second), [0, 5]);
        }
    }
}

/// Random states satisfy nothing that multipliers hold, and least of all what they leave out.
#[test]
fn a_linkage_that_flies_closed_by_multipliers_is_right() {
    let linkage = four_bar(["rate = 2", "", ""], CLOSURES[1]);
    let model = [
        "[nodes]\nground = [0, 0, 0]\n",
        RUN,
        &linkage,
        &body("ground"),
    ]
    .concat();
    assert_right("a linkage", &model, 0..3);
}

/// A weight along the normal of a plane: its parts along the plane cancel, and a base turns them into
/// rounding errors.
#[test]
fn a_weight_on_a_plane_that_a_base_turns_is_right() {
    let text = r#"
[nodes]
o = [0, 0, 0]
[[joints]]
name = "far"
type = "on_surface"
parent = "o"
position = [71.3891907758585, 0, 1]
surface = { sphere = { center = [0, 0, 0] } }
[[joints]]
name = "plane"
type = "on_surface"
parent = "o"
position = [0, 1, 1]
surface = { plane = { normal = [0, 1, 1] } }
[[bodies]]
name = "b2"
node = "far"
mass = 1
inertia = [0.1, 0.2, 0.25]
[[bodies]]
name = "b4"
node = "plane"
mass = 1
inertia = [0.1, 0.2, 0.25]
[[supports]]
node = "o"
fix = "position"
prescribed = { rz = { spin_up = { rate = 3, duration = 0.02 } } }
[[supports]]
node = "o"
fix = ["rx", "ry"]
[[loads]]
gravity = [0.0, 1.000001, 1.000000000001]
[analysis.dynamic]
to = 0.05
step = 0.01
"#;
    assert_right("a plane", text, [0]);
}

/// A four-bar whose rocker is driven by a sine of a frequency far above that of its spring: steps of the
/// balance of power follow the drive.
#[test]
fn a_fast_drive_of_a_loop_is_right() {
    let model = [
        GROUND,
        STATIC,
        &hinge("A", "ground", "spring = { k = 30 }"),
        &arm("ct", "A", [0.0, 1.0, 0.0]),
        &hinge("B", "ct", ""),
        &arm("kt", "B", [1.2, 1.9, 0.0]),
        &arm("foot", "ground", [1.6, 0.0, 0.0]),
        &hinge("D", "foot", "prescribed = { sine = { omega = 1e8 } }"),
        &arm("rt", "D", [1.2, 1.9, 0.0]),
        &hinge("C", "kt", "child = \"rt\""),
        "[[bodies]]\nname = \"crank\"\nnode = \"A\"\nmass = 2\ncenter = [0, 0.5, 0]\n\
         inertia = [0.2, 0.1, 0.3]\n",
    ]
    .concat();
    assert_right("four bars", &model, [0]);
}
