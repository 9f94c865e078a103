//! Runs in time: what is written agrees with closed forms and with the documents.
#![allow(clippy::unwrap_used)]

use crate::support::dynamics::assert_slopes;
use crate::support::program::{
    directory, history, number, program, ran, read, results, succeeded, write,
};
use pullback::input::assemble_text;
use pullback::output::{COLUMNS, DYNAMIC_COLUMNS};
use std::collections::HashMap;
use std::path::Path;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn example(name: &str) -> String {
    read(Path::new(ROOT).join("examples/models").join(name))
}

#[test]
fn rows_are_at_the_multiples_of_an_interval() {
    let directory = directory("program_interval");
    let text = example("pendulum.toml")
        .replace("to = 10\n", "to = 1\nrecord_interval = 0.1\n")
        .replace("step = 0.01\n", "step = 0.003\n");
    let rows = history(&ran(&directory, &text));
    let times: Vec<&str> = rows.iter().map(|row| row["t"].as_str()).collect();
    let round = "0.0 0.1 0.2 0.3 0.4 0.5 0.6 0.7 0.8 0.9 1.0";
    assert_eq!(times, round.split(' ').collect::<Vec<_>>());
    // Elliptic functions (IFToMM benchmark A01): the position at t = 1.
    let last = rows.last().unwrap();
    assert!((number(last, "bob.x") - 0.986291751131875).abs() < 2e-5);
    // 34 steps of 0.1 / 34 between two rows.
    assert_eq!(last["step"], "340");
}

#[test]
fn a_pendulum_records_its_angle_its_forces_and_its_energy() {
    let directory = directory("program_pendulum");
    let out = ran(&directory, &example("pendulum.toml"));
    let head = read(out.join("history.csv"));
    let head = head.lines().next().unwrap();
    assert!(head.starts_with(&format!(
        "{},{}",
        COLUMNS.join(","),
        DYNAMIC_COLUMNS.join(",")
    )));
    let documents = read(Path::new(ROOT).join("docs/model_file.md"));
    for column in DYNAMIC_COLUMNS {
        assert!(documents.contains(&format!("| `{column}` |")), "{column}");
    }
    let rows = history(&out);
    assert_eq!(rows.len(), 1001);
    for row in &rows {
        let angle = number(row, "angle");
        let [x, z] = ["bob.x", "bob.z"].map(|c| number(row, c));
        assert!((x + angle.cos()).abs() < 1e-12 && (z + angle.sin()).abs() < 1e-12);
        assert!((number(row, "support") - number(row, "tension")).abs() < 1e-9);
    }

    let results = results(&out);
    assert_eq!(results["complete"], true);
    let statistics = &results["statistics"];
    for key in [
        "steps",
        "rejected",
        "inaccurate",
        "iterations",
        "evaluations",
    ] {
        assert!(statistics[key].is_u64(), "{key}: {statistics}");
    }
    assert_eq!(statistics["steps"], 1000);
    assert!(statistics["energy"]["largest_defect"].as_f64().unwrap() < 2e-3);
    let last = &results["last"];
    let velocity = last["nodes"]["rod"]["velocity"].as_array().unwrap();
    let momentum = last["motion"]["momentum"].as_array().unwrap();
    assert_eq!(velocity, momentum, "the mass is one");
    assert_eq!(last["reactions"].as_object().unwrap().len(), 1);
    // About 200 grids, with velocities.
    let series = read(out.join("steps.pvd")).matches("<DataSet").count();
    assert!((190..=210).contains(&series), "{series}");
    let grid = read(out.join("step_000000.vtu"));
    assert!(grid.contains("Name=\"velocity\"") && grid.contains("Name=\"angular_velocity\""));
    for figure in ["history.svg", "deformed.svg"] {
        roxmltree::Document::parse(&read(out.join(figure))).unwrap();
    }
}

#[test]
fn what_a_pendulum_records_is_exact_to_the_second_order_of_the_step() {
    let directory = directory("program_pendulum_order");
    let errors = [100, 200, 400].map(|n| {
        let step = format!("step = {}\n", 1.0 / f64::from(n));
        let text = example("pendulum.toml")
            .replace("to = 10\n", "to = 2\n")
            .replace("step = 0.01\n", &step);
        let rows = history(&ran(&directory, &text));
        assert_eq!(rows.len(), 2 * n as usize + 1);
        let largest = |off: &dyn Fn(&HashMap<String, String>) -> f64| {
            rows.iter()
                .map(off)
                .fold(0.0, |most, x| f64::max(most, x.abs()))
        };
        // A bob let go from the horizontal pulls with 3 m g sin θ; its kinetic energy is m g L sin θ.
        let fall = |row: &_| 9.81 * number(row, "angle").sin();
        // Elliptic functions (IFToMM benchmark A01): the position at t = 1.
        let row = &rows[n as usize];
        vec![
            largest(&|row| number(row, "tension") - 3.0 * fall(row).abs()),
            largest(&|row| number(row, "energy")),
            largest(&|row| number(row, "kinetic_energy") - fall(row)),
            (number(row, "bob.x") - 0.986291751131875).abs(),
            (number(row, "bob.z") + 0.165010853125541).abs(),
        ]
    });
    let names = ["tension", "energy", "kinetic energy", "x", "z"];
    assert_slopes("pendulum", &names, &errors, 2.0, 0.1);
}

#[test]
fn springs_motors_and_drives_act_on_released_coordinates() {
    let directory = directory("program_released");
    let model = |acts: &str| {
        let text =
            example("pendulum.toml").replace("gravity = [0, 0, -9.81]", "gravity = [0, 0, 0]");
        let text = text.replace("axis = [0, -1, 0]", &format!("axis = [0, -1, 0]\n{acts}"));
        // Something must be free where the pendulum is driven.
        let text = text.replace("[nodes]", "[nodes]\nother = [5, 0, 0]");
        let body = "[[bodies]]\nname = \"other\"\nnode = \"other\"\nmass = 1\n\n[[supports]]";
        let text = text.replace("[[supports]]", body);
        text.replace("to = 10\nstep = 0.01", "to = 2\nstep = 0.002")
    };
    // J = m L² = 1: θ̈ = 1.5, θ = ¾ t².
    let rows = history(&ran(&directory, &model("actuator = { constant = 1.5 }")));
    for row in &rows {
        let t = number(row, "t");
        assert!((number(row, "angle") - 0.75 * t * t).abs() < 1e-9);
    }
    // ω² = k/J: θ = x₀ (1 − cos ω t) + θ̇₀/ω sin ω t, with a phase error of ω h²/12 per radian.
    let spring = "spring = { k = 9.0, x0 = 0.01 }\nrate = 0.3";
    for row in &history(&ran(&directory, &model(spring))) {
        let (sin, cos) = (3.0 * number(row, "t")).sin_cos();
        let exact = 0.01 * (1.0 - cos) + 0.1 * sin;
        assert!((number(row, "angle") - exact).abs() < 2e-6);
    }
    // A critically damped one: θ = θ̇₀ t e^{−ωt}.
    let rows = history(&ran(
        &directory,
        &model("spring = { k = 9.0, c = 6.0 }\nrate = 0.3"),
    ));
    for row in &rows {
        let t = number(row, "t");
        assert!((number(row, "angle") - 0.3 * t * (-3.0 * t).exp()).abs() < 2e-6);
    }
    let drive = "prescribed = { sine = { amplitude = 2.0, omega = 3.0 } }";
    let rows = history(&ran(&directory, &model(drive)));
    for row in &rows {
        let t = number(row, "t");
        assert!((number(row, "angle") - 2.0 * (3.0 * t).sin()).abs() < 1e-12);
        // Centripetal and tangential force of the unit mass.
        let (rate, slope) = (6.0 * (3.0 * t).cos(), -18.0 * (3.0 * t).sin());
        let force = (rate * rate).hypot(slope);
        assert!((number(row, "tension") - force).abs() < 1e-9 * (1.0 + force));
    }
}

#[test]
fn every_model_of_the_documents_assembles() {
    let documents = read(Path::new(ROOT).join("docs/model_file.md"));
    let models: Vec<&str> = documents.split("```toml\n").skip(1).collect();
    assert_eq!(models.len(), 2);
    for (k, model) in models.iter().enumerate() {
        let text = model.split("```").next().unwrap();
        assemble_text(&format!("model {k} of docs/model_file.md"), text).unwrap();
    }
}

#[test]
fn a_step_that_is_too_large_is_halved_and_counted() {
    let directory = directory("program_halved");
    // Each step would turn the rod by more than the chart holds.
    let text = r#"
[nodes]
A = [0, 0, 0]

[[bodies]]
name = "top"
node = "A"
mass = 1
inertia = [1, 2, 2.5]

[[initial]]
node = "A"
angular_velocity = [40, 1, 1]

[analysis.dynamic]
to = 1
step = 0.25
newton = { max_iterations = 5 }
"#;
    let out = ran(&directory, text);
    let statistics = &results(&out)["statistics"];
    assert!(statistics["rejected"].as_u64().unwrap() > 0, "{statistics}");
    assert!(statistics["largest_rotation"].as_f64().unwrap() > 1.0);
    let rows = history(&out);
    assert!((number(rows.last().unwrap(), "t") - 1.0).abs() < 1e-12);
}

#[test]
fn adaptive_steps_keep_the_error_and_are_counted() {
    let directory = directory("program_adaptive");
    let text = example("pendulum.toml").replace(
        "step = 0.01",
        "step = 0.01\nadaptive = { tolerance = 1e-7, max_step = 0.1 }",
    );
    let out = ran(&directory, &text);
    let rows = history(&out);
    let steps: Vec<f64> = rows
        .iter()
        .skip(1)
        .map(|r| number(r, "step_size"))
        .collect();
    let (least, most) = steps
        .iter()
        .fold((1.0_f64, 0.0_f64), |(a, b), h| (a.min(*h), b.max(*h)));
    assert!(most > 1.5 * least && most <= 0.1, "{least} to {most}");
    let last = rows.last().unwrap();
    assert!((number(last, "bob.x") + 0.275087462576117).abs() < 2e-3);
    assert!(results(&out)["statistics"]["inaccurate"].is_u64());
}

#[test]
fn rates_of_joints_follow_an_initial_rotation_and_starts_that_strain_are_told() {
    let directory = directory("program_starts");
    let rod = r#"
[sections.rod]
stiffness = { EA = 1e6, GA = [1e6, 1e6], GJ = 1e4, EI = [1e4, 1e4] }
mass = { A_rho = 1, J = [2e-3, 1e-3, 1e-3] }

[nodes]
ground = [0, 0, 0]
tip = [1, 0, 0]

[[joints]]
name = "pivot"
type = "revolute"
parent = "ground"
axis = [0, 0, 1]

[[lines]]
name = "rod"
from = "pivot"
to = "tip"
elements = 2
section = "rod"

[[supports]]
node = "ground"
fix = "all"

[[initial]]
line = "rod"
angular_velocity = [0, 0, 2]

[analysis.dynamic]
to = 0.1
step = 0.001

[[probes]]
name = "rate"
quantity = "joint_rate"
joint = "pivot"
"#;
    // A rigid turn goes on: the hinge turns with the rod from the start.
    for row in history(&ran(&directory, rod)) {
        assert!((number(&row, "rate") - 2.0).abs() < 1e-3, "{}", row["rate"]);
    }
    let driven = rod
        .replace(
            "axis = [0, 0, 1]",
            "axis = [0, 0, 1]\nprescribed = { constant = 0.1 }",
        )
        .replace(
            "[[initial]]\nline = \"rod\"\nangular_velocity = [0, 0, 2]\n",
            "",
        );
    let output = program(&[&write(&directory, &driven)]);
    let said = succeeded(&output);
    assert!(
        said.contains("warning: joint pivot is not where the model is drawn"),
        "{said}"
    );
}
