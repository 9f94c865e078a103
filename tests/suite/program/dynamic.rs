//! Runs in time: what is written agrees with closed forms and with the documents.

use crate::support::beams::line;
use crate::support::dynamics::assert_slopes;
use crate::support::included::blocks;
use crate::support::*;
use pullback::input::assemble_text;
use pullback::output::{COLUMNS, DYNAMIC_COLUMNS};
use roxmltree::Document;
use std::collections::HashMap;
use std::f64::consts::FRAC_PI_2;

/// The page of model files.
const DOCUMENTS: &str = include_str!("../../../docs/model_file.md");

/// The pendulum of the examples with other words.
fn pendulum(changes: &str) -> String {
    changed(&example("pendulum"), changes)
}

#[test]
fn rows_are_at_the_multiples_of_an_interval() {
    let text = pendulum("to = 10 => to = 1\\nrecord_interval = 0.1\nstep = 0.01 => step = 0.003");
    let rows = recorded("program_interval", &text);
    let times: Vec<&str> = rows.iter().map(|row| row["t"].as_str()).collect();
    let round = "0.0 0.1 0.2 0.3 0.4 0.5 0.6 0.7 0.8 0.9 1.0";
    assert_eq!(times, round.split(' ').collect::<Vec<_>>());
    // Elliptic functions (IFToMM benchmark A01): the position at t = 1.
    let last = rows.last().unwrap();
    assert_close(number(last, "bob.x"), 0.986291751131875, 2e-5, "bob");
    // 34 steps of 0.1 / 34 between two rows.
    assert_eq!(last["step"], "340");
}

#[test]
fn a_pendulum_records_its_angle_its_forces_and_its_energy() {
    let run = run_of("program_pendulum", &pendulum(""));
    let head = [COLUMNS.as_slice(), &DYNAMIC_COLUMNS].concat().join(",");
    assert!(read(run.out.join("history.csv")).starts_with(&head));
    for column in DYNAMIC_COLUMNS {
        assert_says(DOCUMENTS, &[&format!("| `{column}` |")]);
    }
    assert_eq!(run.rows.len(), 1001);
    for row in &run.rows {
        let [angle, x, z] = ["angle", "bob.x", "bob.z"].map(|column| number(row, column));
        assert_close(x, -angle.cos(), 1e-12, "x");
        assert_close(z, -angle.sin(), 1e-12, "z");
        assert_close(number(row, "support"), number(row, "tension"), 1e-9, angle);
    }

    assert_eq!(run.result["complete"], true);
    let statistics = &run.result["statistics"];
    for key in "steps rejected inaccurate iterations evaluations".split(' ') {
        assert!(statistics[key].is_u64(), "{key}: {statistics}");
    }
    assert_eq!(statistics["steps"], 1000);
    assert!(statistics["energy"]["largest_defect"].as_f64().unwrap() < 2e-3);
    let last = &run.result["last"];
    // The mass is one.
    let velocity = &last["nodes"]["rod"]["velocity"];
    assert!(velocity.is_array() && *velocity == last["motion"]["momentum"]);
    assert_eq!(last["reactions"].as_object().unwrap().len(), 1);
    // About 200 grids, with velocities.
    let series = read(run.out.join("steps.pvd")).matches("<DataSet").count();
    assert!((190..=210).contains(&series), "{series}");
    let grid = read(run.out.join("step_000000.vtu"));
    let names = ["velocity", "angular_velocity"].map(|name| format!("Name=\"{name}\""));
    assert_says(&grid, &names.each_ref().map(String::as_str));
    for figure in ["history.svg", "deformed.svg"] {
        Document::parse(&read(run.out.join(figure))).unwrap();
    }
}

#[test]
fn what_a_pendulum_records_is_exact_to_the_second_order_of_the_step() {
    let errors = [100, 200, 400].map(|n| {
        let step = 1.0 / f64::from(n);
        let text = pendulum(&format!("to = 10 => to = 2\nstep = 0.01 => step = {step}"));
        let rows = recorded("program_pendulum_order", &text);
        assert_eq!(rows.len(), 2 * n as usize + 1);
        let largest = |off: &dyn Fn(&HashMap<String, String>) -> f64| {
            let off = rows.iter().map(|row| off(row).abs());
            off.fold(0.0, f64::max)
        };
        // A bob let go from the horizontal pulls with 3 m g sin θ; its kinetic energy is m g L sin θ.
        let fall = |row: &_| 9.81 * number(row, "angle").sin();
        vec![
            largest(&|row| number(row, "tension") - 3.0 * fall(row).abs()),
            largest(&|row| number(row, "energy")),
            largest(&|row| number(row, "kinetic_energy") - fall(row)),
        ]
    });
    let names = ["tension", "energy", "kinetic energy"];
    assert_slopes("pendulum", &names, &errors, 2.0, 0.1);
}

#[test]
fn a_motion_begins_in_equilibrium() {
    // A cantilever bent far, by a load that Newton's method does not balance at once. The elastica by elliptic
    // integrals (Bisshopp & Drucker 1945) ends at 1 − 0.55500, 0.81061, and stays there.
    let mass = "EI = [1, 1] } => &\\nmass = { A_rho = 1, J = [2e-3, 1e-3, 1e-3] }";
    let begins = "[analysis.dynamic]\nto = 0.1\nstep = 0.01\nfrom_equilibrium = true\n";
    let bent = changed(&example("elastica"), mass) + begins;
    for row in recorded("program_equilibrium", &bent) {
        for (column, exact) in [("tip.x", -0.55500), ("tip.y", 0.81061)] {
            assert_close(number(&row, column), exact, 1e-5, &row["t"]);
        }
    }
    // A rate starts from there: −m g/k + v/ω sin ωt.
    let text = [
        GROUND,
        &joint(
            "rod",
            "prismatic",
            "ground",
            "axis = [0, 0, 1]\nspring = { k = 100 }\nrate = 0.5",
        ),
        &body_of("rod", 4.0, "inertia = [1, 1, 1]"),
        GRAVITY,
        &probe_of("z", "joint_coordinate", "joint = \"rod\""),
        "[analysis.dynamic]\nto = 1\nstep = 0.01\nscheme = \"tsitouras\"\nfrom_equilibrium = true\n",
    ];
    for row in recorded("program_equilibrium", &text.concat()) {
        let exact = -0.3924 + 0.1 * (5.0 * number(&row, "t")).sin();
        assert_close(number(&row, "z"), exact, 1e-8, &row["t"]);
    }
    // A penalty keeps the gap that carries the weight, m g/p.
    let held = "child = \"body\"\nclosure = \"penalty\"\npenalty = 1e4";
    let text = [
        "[nodes]\nground = [0, 0, 0]\nbody = [0, 0, 0]\n",
        &fixed("ground"),
        &joint("weld", "weld", "ground", held),
        &body_of("body", 4.0, "inertia = [1, 1, 1]"),
        GRAVITY,
        &probe("d", "displacement", "body"),
        begins,
    ];
    for row in recorded("program_equilibrium", &text.concat()) {
        assert_close(number(&row, "d.z"), -39.24e-4, 1e-12, &row["t"]);
    }
}

#[test]
fn the_equilibrium_at_the_start_is_near_and_told_if_it_is_unstable() {
    // A `value` is a first guess. The load is reduced step by step, so that a pendulum hangs down from 79°, and
    // stands if it is beyond the horizontal.
    let begins = "to = 10 => from_equilibrium = true\\nto = 0.1\n";
    for (value, angle) in [(0.2, FRAC_PI_2), (-0.2, -FRAC_PI_2)] {
        let text = pendulum(&format!("{begins}axis = [0, => value = {value}\\n&"));
        let run = run_of("program_equilibrium", &text);
        assert_close(number(&run.rows[0], "angle"), angle, 1e-9, value);
        let warned = run.said.contains("unstable in 1 direction");
        assert_eq!(warned, value < 0.0, "{}", run.said);
    }
    // In every formulation: k θ = m g l sin(α − θ), drawn α = 70° away.
    let (x, z) = 70.0_f64.to_radians().sin_cos();
    let center = format!("center = [{x}, 0, {}]\ninertia = [0.2, 0.3, 0.4]", -z);
    for scheme in ["newmark", "ul-newmark", "lie-newmark"] {
        let text = [
            GROUND,
            &joint("ball", "spherical", "ground", ""),
            &body_of("ball", 2.0, &center),
            "[[springs]]\nname = \"spring\"\nnodes = [\"ground\", \"ball\"]\n\
             bushing = { stiffness = [1, 1, 1, 0.01, 0.01, 0.01] }\n",
            GRAVITY,
            &probe("turn", "rotation", "ball"),
            &format!(
                "{}scheme = \"{scheme}\"\nfrom_equilibrium = true\n",
                motion(0.01, 0.005)
            ),
        ];
        let turn = number(
            &recorded("program_equilibrium", &text.concat())[0],
            "turn.y",
        );
        let moment = 2.0 * 9.81 * (70.0_f64.to_radians() - turn).sin();
        assert!(turn > 0.0, "{scheme}: {turn}");
        assert_close(0.01 * turn, moment, 1e-9, scheme);
    }
    check(
        &pendulum(begins),
        "from_equilibrium",
        "what moves without resistance:\n    pivot angle",
        "nearer to an equilibrium",
    );
}

#[test]
fn every_model_of_the_documents_assembles() {
    let models = blocks(DOCUMENTS, "```toml\n");
    assert_eq!(models.len(), 2);
    for (k, model) in models.into_iter().enumerate() {
        assemble_text(&format!("model {k} of docs/model_file.md"), model).unwrap();
    }
}

#[test]
fn a_step_that_is_too_large_is_halved_and_counted() {
    // Each step would turn the rod by more than the chart holds.
    let text = [
        "[nodes]\nA = [0, 0, 0]\n",
        &body_of("A", 1.0, "inertia = [1, 2, 2.5]"),
        "[[initial]]\nnode = \"A\"\nangular_velocity = [40, 1, 1]\n",
        &motion(1.0, 0.25),
        "newton = { max_iterations = 5 }\n",
    ];
    let run = run_of("program_halved", &text.concat());
    let statistics = &run.result["statistics"];
    assert!(statistics["rejected"].as_u64().unwrap() > 0, "{statistics}");
    assert!(statistics["largest_rotation"].as_f64().unwrap() > 1.0);
    let end = number(run.rows.last().unwrap(), "t");
    assert_close(end, 1.0, 1e-12, "the end");
}

#[test]
fn adaptive_steps_keep_the_error_and_are_counted() {
    let adaptive = "step = 0.01 => &\\nadaptive = { tolerance = 1e-7, max_step = 0.1 }";
    let run = run_of("program_adaptive", &pendulum(adaptive));
    let steps = || run.rows.iter().skip(1).map(|r| number(r, "step_size"));
    let (least, most) = (steps().fold(1.0, f64::min), steps().fold(0.0, f64::max));
    assert!(most > 1.5 * least && most <= 0.1, "{least} to {most}");
    let x = number(run.rows.last().unwrap(), "bob.x");
    assert_close(x, -0.275087462576117, 2e-3, "the end");
    assert!(run.result["statistics"]["inaccurate"].is_u64());
}

#[test]
fn rates_of_joints_follow_an_initial_rotation() {
    let rest = [
        &hinge("pivot", "A", ""),
        "[sections.main.mass]\nA_rho = 1\nJ = [2e-3, 1e-3, 1e-3]\n",
        &fixed("A"),
        "[[initial]]\nline = \"line\"\nangular_velocity = [0, 0, 2]\n",
        &probe_of("rate", "joint_rate", "joint = \"pivot\""),
        &motion(0.1, 0.001),
    ];
    let stiffness = "EA = 1e6, GA = [1e6, 1e6], GJ = 1e4, EI = [1e4, 1e4]";
    let text = line(stiffness, 2, 1, &rest.concat());
    let text = changed(&text, "from = \"A\" => from = \"pivot\"");
    // A rigid turn goes on: the hinge turns with the rod from the start.
    for row in recorded("program_starts", &text) {
        assert_close(number(&row, "rate"), 2.0, 1e-3, &row["t"]);
    }
}

/// A body that coasts on a hinge: corrections that are zero twice in a row say that it does.
#[test]
fn a_coasting_body_takes_no_smaller_steps() {
    let text = [
        GROUND,
        &hinge("hub", "ground", "value = 0.3\nrate = 2"),
        &body_of("hub", 1.0, "inertia = [1, 1, 1]"),
        &motion(0.2, 0.001),
        "scheme = \"radau\"\n",
        PLAIN,
        &probe_of("angle", "joint_coordinate", "joint = \"hub\""),
    ];
    let rows = recorded("program_coasts", &text.concat());
    assert_eq!(rows.len(), 201);
    for row in rows {
        let exact = 0.3 + 2.0 * number(&row, "t");
        assert_close(number(&row, "angle"), exact, 1e-13, &row["t"]);
    }
}

/// The rate of an arm that carries a body on joints, and the body's velocity and angular velocity, in the first row.
fn assert_started(rate: &str, joints: &str, entries: &str, expected: [f64; 7]) {
    let text = [
        GROUND,
        &hinge("arm", "ground", rate),
        joints,
        &body_of("arm", 1.0, "inertia = [1, 1, 1]"),
        &body_of("body", 1.0, "inertia = [1, 1, 1]"),
        entries,
        &motion(0.1, 0.1),
        &probe_of("arm", "joint_rate", "joint = \"arm\""),
        &probe("v", "velocity", "body"),
        &probe("w", "angular_velocity", "body"),
    ]
    .concat();
    let rows = recorded("program_on_joints", &text);
    let columns = ["arm", "v.x", "v.y", "v.z", "w.x", "w.y", "w.z"];
    for (column, exact) in columns.iter().zip(expected) {
        let what = format!("{column} {text}");
        assert_close(number(&rows[0], column), exact, 1e-14, what);
    }
}

/// They take velocities by entries, whatever their order, and in space.
#[test]
fn nodes_on_joints_take_the_velocities_that_their_joints_allow() {
    let free = joint("body", "free", "arm", "position = [0.5, 0.2, 0]");
    let body =
        "[[initial]]\nnode = \"body\"\nvelocity = [1, 2, 3]\nangular_velocity = [0.3, 0.2, 0.1]\n";
    let turned = "[[initial]]\nnode = \"arm\"\nangular_velocity = [0, 0, 2]\n";
    let corrected = "[[initial]]\nnode = \"body\"\nvelocity = [1, 0, 3]\n";
    let all = "[[initial]]\nangular_velocity = [0, 0, 1]\n";
    let moved = "[[initial]]\nvelocity = [1, 2, 3]\nangular_velocity = [0.3, 0, 0.1]\n";
    let both = [2.0, 1.0, 2.0, 3.0, 0.3, 0.2, 0.1];
    let one = [2.0, 1.0, 0.0, 3.0, 0.3, 0.2, 0.1];
    for (rate, entries, expected) in [
        ("", &[body, turned][..], both),
        ("", &[turned, body], both),
        ("", &[turned], [2.0, -0.4, 1.0, 0.0, 0.0, 0.0, 2.0]),
        // Later entries overwrite earlier ones, and only what they give.
        ("", &[body, turned, corrected], one),
        (
            "",
            &[body, turned, all],
            [1.0, -0.2, 0.5, 0.0, 0.0, 0.0, 1.0],
        ),
        // The arm moves as its `rate` says, what is free behind it as the whole model does: v + ω × x.
        ("rate = 2", &[moved], [2.0, 0.98, 2.05, 3.06, 0.3, 0.0, 0.1]),
    ] {
        assert_started(rate, &free, &entries.concat(), expected);
    }
    // The angular velocity of a ball joint leaves the arm alone.
    let ball = arm("end", "arm", [0.5, 0.0, 0.0]) + &joint("body", "spherical", "end", "");
    let own = "[[initial]]\nnode = \"body\"\nangular_velocity = [0, 2, 3]\n";
    for (entries, rate) in [(&[all, own][..], 1.0), (&[own], 0.0)] {
        let expected = [rate, 0.0, 0.5 * rate, 0.0, 0.0, 2.0, 3.0];
        assert_started("", &ball, &entries.concat(), expected);
    }
    // A node without coordinates of its own moves with those before it: v = ω × (0.5, 0, 0).
    let tip = ball + &arm("tip", "body", [1.0, 0.0, 0.0]);
    for entry in ["velocity = [0, 1.5, -1]", "angular_velocity = [0, 2, 3]"] {
        let of_tip = format!("[[initial]]\nnode = \"tip\"\n{entry}\n");
        assert_started("", &tip, &of_tip, [0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 3.0]);
    }
}

/// Entries for one node leave alone what only the others give, and read its place and its axes with what is prescribed.
#[test]
fn entries_for_one_node_leave_each_other_alone() {
    let start = |support: &str, entries: &str| {
        let text = [
            "[nodes]\nO = [1, 2, 3]\n",
            &body_of("O", 1.0, "inertia = [1, 1, 1]"),
            support,
            entries,
            &motion(0.1, 0.1),
            &probe("d", "displacement", "O"),
            &probe("r", "rotation", "O"),
            &probe("v", "velocity", "O"),
            &probe("w", "angular_velocity", "O"),
        ]
        .concat();
        recorded("program_entries", &text).swap_remove(0)
    };
    let entry = |keys: &str| format!("[[initial]]\nnode = \"O\"\n{keys}\n");
    let held = |keys: &str| format!("[[supports]]\nnode = \"O\"\n{keys}\n");
    let assert = |row: &HashMap<String, String>, name: &str, exact: [f64; 3]| {
        for (axis, exact) in ["x", "y", "z"].iter().zip(exact) {
            assert_close(number(row, &format!("{name}.{axis}")), exact, 1e-13, name);
        }
    };
    let place = entry("displacement = [0.1, 0.2, 0.3]");
    let turn = entry("rotation = [0, 0.1, 0.2]");
    let moves = entry("velocity = [0, 1, 0]");
    for entries in [
        [&place, &turn, &moves],
        [&moves, &turn, &place],
        [&turn, &moves, &place],
    ] {
        let row = start("", &entries.map(String::as_str).concat());
        assert(&row, "d", [0.1, 0.2, 0.3]);
        assert(&row, "r", [0.0, 0.1, 0.2]);
        assert(&row, "v", [0.0, 1.0, 0.0]);
    }
    // About the node itself, wherever it is prescribed to be.
    let spun = entry("velocity = [0, 1, 0]\nangular_velocity = [0, 0, 1]");
    let aside = held("prescribed = { x = { constant = 0.5 } }\nfix = [\"z\"]");
    let row = start(&aside, &spun);
    assert(&row, "v", [0.0, 1.0, 0.0]);
    // R(0.5 e1) 2 e3.
    let (sin, cos) = 0.5_f64.sin_cos();
    let turned = held("prescribed = { rx = { constant = 0.5 } }");
    let row = start(&turned, &entry("body_angular_velocity = [0, 0, 2]"));
    assert(&row, "w", [0.0, -2.0 * sin, 2.0 * cos]);
}
