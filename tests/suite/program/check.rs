//! `pullback check`: every model of the gallery passes, and what it prints and returns.

use crate::support::*;
use pullback::check;
use pullback::input::Job;
use pullback::studies::gallery::MODELS;

#[test]
fn all_models_of_the_gallery_pass() {
    for (name, text) in MODELS {
        assert_right(name, text, [0]);
    }
    assert!(MODELS.len() >= 25);
}

/// Nothing is wrong in a model at the random states of some seeds; the job of the last one.
#[track_caller]
fn assert_right(what: &str, text: &str, seeds: impl IntoIterator<Item = u64>) -> Job {
    let jobs = seeds.into_iter().map(|seed| {
        let mut job = pullback::input::assemble_text(what, text).unwrap();
        let report = check::job(&mut job, seed);
        let table = check::table(&report);
        assert!(report.is_ok(), "{what}, seed {seed}\n{table}");
        assert!(report.rows().len() > 10, "{table}");
        job
    });
    jobs.last().unwrap()
}

/// The model numbers its unknowns from the tips of its lines: those of the supports come first.
#[test]
fn a_frame_of_two_members_is_right_at_random_states() {
    assert_right("Lee's frame", &example("lee_frame"), [1, 3]);
}

/// A beam behind a slider in millimetres, which are numbered before it; and a bushing between positions that differ by a
/// rounding error.
#[test]
fn models_are_right_in_small_units_and_at_rounded_positions() {
    let text = r#"
        nodes = { ground = [0, 0, 0], tip = [2000.0, 200.0, 0] }
        supports = [{ node = "ground", fix = "all" }]
        joints = [{ name = "slider", type = "prismatic", parent = "ground", axis = [0, 1, 0] }]
        lines = [{ name = "beam", from = "slider", to = "tip", elements = 1, section = "s" }]
        [sections.s]
        stiffness = { EA = 3e6, GA = [1e6, 1e6], GJ = 8e9, EI = [12e9, 12e9] }
        mass = { A_rho = 0.001, J = [6.0, 6.0, 6.0] }
        [analysis.dynamic]
        to = 1.0
        step = 0.01
    "#;
    assert_right("millimetres", text, 0..4);
    let text = r#"
        nodes = { ground = [0, 0, 0] }
        supports = [{ node = "ground", fix = "all" }]
        joints = [
            { name = "base", type = "offset", parent = "ground", position = [0.3, 0, 0] },
            { name = "arm", type = "offset", parent = "ground", position = [0.30000000000000004, 0, 0] },
            { name = "car", type = "prismatic", parent = "arm", axis = [1, 1, 0] },
        ]
        bodies = [{ name = "mass", node = "car", mass = 1, inertia = [0.1, 0.1, 0.1] }]
        springs = [{ name = "b", nodes = ["base", "car"], bushing = { stiffness = [5, 5, 5, 1, 1, 1] } }]
        [analysis.dynamic]
        to = 1.0
        step = 0.01
    "#;
    assert_right("rounded", text, 0..4);
}

#[test]
fn the_table_and_the_rows_of_a_model() {
    let directory = directory("program_check");
    write(&directory, MODEL);
    // A line for each component by default.
    let printed = |more: &str| {
        let output = program_in(&directory, &format!("check model.toml {more}"));
        assert_eq!(ended(&output, 0), "");
        String::from_utf8(output.stdout).unwrap()
    };
    let short = printed("");
    let start = "element beam:* (beam), 8 of them  ";
    let beams: Vec<&str> = short.lines().filter(|l| l.starts_with(start)).collect();
    assert_eq!(beams.len(), 1, "{short}");
    assert!(beams[0].contains(" (worst of "), "{short}");
    assert!(!short.contains("Beam<"), "{short}");
    let table = printed("--all");
    assert!(table.lines().count() > 2 * short.lines().count());
    let beams = "element beam:* (beam), 8 of them";
    let words = ["component", "K = -dr/dx", beams, "load load 1"];
    assert_says(&table, &words);
    assert_says(&table, &["10 components, 0 wrong"]);
    let json = printed("--json --seed 3");
    let rows: Vec<serde_json::Value> = serde_json::from_str(&json).unwrap();
    assert!(rows.len() > 100, "{}", rows.len());
    for row in &rows {
        assert_eq!(row["passed"], true, "{row}");
        let numbers = ["value", "limit"].map(|key| row[key].is_number());
        assert_eq!(numbers, [true; 2], "{row}");
    }
    for component in ["model", "element beam:8 (beam)"] {
        assert!(rows.iter().any(|r| r["component"] == component));
    }
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
    let words = [
        "FAIL element pin (Pin): K symmetric",
        "K (rows: rotation of node a; columns: displacement of node b): off by 2.000e0",
        "it is 0.500 times what is right",
        "1 properties of 1 components, 1 wrong",
    ];
    assert_says(&table, &words);
    let entries = check::entries(&report);
    assert_eq!(entries[0]["passed"], false);
    assert_eq!(entries[0]["blocks"][0]["factor"], 0.5);
}

#[test]
fn a_mechanism_by_the_names_of_its_file() {
    let directory = directory("program_check_names");
    write(&directory, &example("four_bar"));
    let words = [
        "joint C closes a loop; independent: A angle; redundant: ",
        "degrees of freedom: 1 of 4 coordinates, 1 loop with 6 equations, of which 3 are redundant",
        "joint A (revolute)",
        "joint crank tip (offset)",
        "coordinate B angle (in a loop)",
        "\ncoordinates of C (closed loop)",
        "element body crank (rigid body)",
    ];
    assert_says(&printed(&directory, "check model.toml"), &words);
}

/// At the end of its chain, and near a node of it: a random state is on another line, with another corner, than
/// the start.
#[test]
fn a_slide_may_start_anywhere_on_its_chain() {
    for (start, seeds) in [(0.0, 3), (1.0, 3), (0.37, 6), (0.38, 6)] {
        let bead = format!(
            "[[joints]]\nname = \"bead\"\ntype = \"slide\"\nlines = [\"beam\"]\nstart = {start}\n\
             spring = {{ k = 1 }}\n\n[[loads]]\nnode = \"bead\"\nforce = [0, 0, -1]\n\n[analysis"
        );
        let model = with("[analysis", &bead);
        assert_right(&format!("a start at {start}"), &model, 0..seeds);
    }
}

/// The third derivative of a curve through points jumps at them, where a closed one starts by default.
#[test]
fn a_point_on_a_curve_may_start_at_a_point_that_it_leads_through() {
    for start in ["closed = true", "start = 1.0198039027185569"] {
        let through = "through = [[-1, 0, 0.2], [0, 0, 0], [1, 0.3, 0], [2, 0, 0.1], [3, 0.5, 0]]";
        let curve = joint("p", "on_curve", "ground", &format!("{start}\n{through}"));
        let model = [GROUND, &curve, &body("p"), GRAVITY, RUN].concat();
        assert_right(start, &model, 0..6);
    }
}

/// Redundant equations whose multipliers are left out do no work at a crank that is prescribed.
#[test]
fn a_driven_loop_in_a_tilted_plane_is_right() {
    let hinge = |name: &str, parent: &str, more: &str| {
        let axis = format!("axis = [0.36, 0.48, 0.8]\n{more}");
        joint(name, "revolute", parent, &axis)
    };
    let tip = |name: &str, parent: &str| arm(name, parent, [-1.1958, -1.3454, 1.3454]);
    let closed = "child = \"rocker tip\"\nclosure = \"multipliers\"";
    let model = [
        GROUND,
        &hinge("crank", "ground", "prescribed = { proportional = 1.0 }"),
        &arm("pin", "crank", [-0.0407, -0.8486, 0.5275]),
        &hinge("coupler", "pin", ""),
        &tip("coupler tip", "coupler"),
        &arm("foot", "ground", [-1.4913, 0.3559, 0.4576]),
        &hinge("rocker", "foot", ""),
        &tip("rocker tip", "rocker"),
        &hinge("close", "coupler tip", closed),
        &["crank", "coupler", "rocker"].map(body).concat(),
        RUN,
    ];
    assert_right("tilted", &model.concat(), 0..4);
}

/// Where a joint of a loop is driven, what its drive does at a state that is out of balance depends on
/// which coordinates are free: only with what is out of balance it is the power that stays.
#[test]
fn a_driven_joint_of_a_loop_may_have_other_coordinates_beside_it() {
    // Drives and seeds with which the last state is far enough from the first to change the free coordinate.
    for (drive, seed) in [
        ("amplitude = 1, omega = 3", 4),
        ("amplitude = 0.5, omega = 0.3", 2),
        ("amplitude = -0.8, omega = 3", 9),
    ] {
        let driven = format!("prescribed = {{ sine = {{ {drive} }} }}");
        let model = [
            &*five_bar([&driven, "", ""]),
            &body("B"),
            &body("D").replace("mass", "center = [0.5, 0, 0]\nmass"),
            "[[loads]]\ngravity = [-9.81, 0, 0]\n",
        ]
        .concat();
        let before = started(&model).context.descriptions();
        let job = assert_right(drive, &model, [seed]);
        assert_ne!(job.context.descriptions(), before, "{drive}");
    }
}

/// Two rigid links from the coupler of a linkage to the same frame, one of them by a stiff penalty:
/// what it does cancels, and leaves its round-off in the tangent.
#[test]
fn a_redundant_rigid_link_by_a_penalty_is_no_error() {
    let stiff =
        "child = \"coupler tip\"\nclosure = \"penalty\"\npenalty = 1e9\npenalty_damping = 1e-3";
    let again = arm("again", "link", [1.2, 1.9, 0.0]) + stiff;
    let links = [&arm("link", "B", [0.5, 1.5, 0.0]), &*again, "\n[[bodies]]"].concat();
    let text = example("four_bar").replacen("[[bodies]]", &links, 1);
    assert_right("four bars", &text, 0..13);
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
        GRAVITY,
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
            &["b", "d", "e", "f"].map(body).concat(),
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
    let ground = "[nodes]\nground = [0, 0, 0]\n";
    let model = [ground, RUN, &linkage, &body("ground")].concat();
    assert_right("a linkage", &model, 0..3);
}

/// A weight along the normal of a plane: its parts along the plane cancel, and a base turns them into
/// rounding errors.
#[test]
fn a_weight_on_a_plane_that_a_base_turns_is_right() {
    let surface = |name: &str, position: &str, surface: &str| {
        let more = format!("position = {position}\nsurface = {{ {surface} }}");
        joint(name, "on_surface", "o", &more) + &body_of(name, 1.0, "inertia = [0.1, 0.2, 0.25]")
    };
    let ball = "sphere = { center = [0, 0, 0] }";
    let turned = "prescribed = { rz = { spin_up = { rate = 3, duration = 0.02 } } }\n";
    let model = [
        "[nodes]\no = [0, 0, 0]\n",
        &surface("far", "[71.3891907758585, 0, 1]", ball),
        &surface("plane", "[0, 1, 1]", "plane = { normal = [0, 1, 1] }"),
        &fixed("o").replace("\"all\"", "[\"x\", \"y\", \"z\", \"rx\", \"ry\"]"),
        turned,
        "[[loads]]\ngravity = [0.0, 1.000001, 1.000000000001]\n",
        "[analysis.dynamic]\nto = 0.05\nstep = 0.01\n",
    ]
    .concat();
    assert_right("a plane", &model, [0]);
}

/// A four-bar whose rocker is driven by a sine of a frequency far above that of its spring: steps of the
/// balance of power follow the drive.
#[test]
fn a_fast_drive_of_a_loop_is_right() {
    let fast = "prescribed = { sine = { omega = 1e8 } }";
    let linkage = four_bar(["spring = { k = 30 }", "", fast], "");
    let model = [GROUND, STATIC, &linkage].concat();
    assert_right("four bars", &model, [0]);
}

/// The nodes of a blade have coordinates relative to its hub: those of neighbours are close to each other.
#[test]
fn a_blade_on_a_turned_hub_is_right() {
    let (_, blade) = (MODELS.iter().find(|(name, _)| *name == "rotating_blade")).unwrap();
    let (parts, _) = blade.split_once("[analysis").unwrap();
    let turned = parts.replacen("axis", "value = 3\naxis", 1);
    let model = turned.replace("elements = 8", "elements = 3") + RUN;
    assert_right("a blade", &model, 0..4);
}
