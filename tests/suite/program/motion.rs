//! Motions of model files step by step.

#![allow(clippy::unwrap_used)]

use crate::support::program::{directory, history, number, program_in, read, succeeded};
use pullback::input::assemble_text;
use pullback::motion::{Motion, MotionError};

fn pendulum() -> Motion {
    let text = read("examples/models/pendulum.toml");
    Motion::new(assemble_text("pendulum.toml", &text).unwrap()).unwrap()
}

/// The probes of each step are those of a run of the program.
#[test]
fn steps_are_those_of_a_run() {
    let directory = directory("motion");
    let file = directory.join("pendulum.toml");
    std::fs::copy("examples/models/pendulum.toml", file).unwrap();
    succeeded(&program_in(&directory, "run pendulum.toml"));
    let mut motion = pendulum();
    for row in history(&directory.join("pendulum.out")) {
        assert_eq!(motion.state().t, number(&row, "t"));
        for (probe, columns) in [
            ("angle", vec!["angle"]),
            ("tension", vec!["tension"]),
            ("support", vec!["support"]),
            ("energy", vec!["energy"]),
            ("bob", vec!["bob.x", "bob.y", "bob.z"]),
        ] {
            let values = columns.iter().map(|column| number(&row, column));
            let found = motion.probe(probe).unwrap();
            assert!(found.iter().map(|x| x + 0.0).eq(values), "{probe}");
        }
        motion.step().unwrap();
    }
    assert!(!motion.step().unwrap());
}

/// A motion that goes on with another step size is that of a simulation with it; a copy repeats it to the last bit.
#[test]
fn step_sizes_change_and_copies_repeat() {
    let mut motion = pendulum();
    for _ in 0..10 {
        assert!(motion.step().unwrap());
    }
    motion.set_step(0.02).unwrap();
    let saved = motion.save();
    let mut angles = Vec::new();
    for again in [false, true] {
        motion.restore(&saved).unwrap();
        for k in 0..10 {
            assert!(motion.step().unwrap());
            let angle = motion.probe("angle").unwrap()[0];
            match again {
                false => angles.push(angle),
                true => assert_eq!(angles[k], angle),
            }
        }
        assert!((motion.state().t - 0.3).abs() < 1e-12);
    }
    assert!(matches!(
        motion.set_step(f64::NAN),
        Err(MotionError::Dynamics(_))
    ));
    assert!(matches!(
        motion.set_step(0.0),
        Err(MotionError::Dynamics(_))
    ));
    assert!(motion.step().unwrap());
}

/// A rotation about a fixed axis counts its turns, whether or not its probe is read at each step.
#[test]
fn turns_are_counted_between_readings() {
    let text = r#"
        [nodes]
        ground = [0, 0, 0]
        [[supports]]
        node = "ground"
        fix = "all"
        [[joints]]
        name = "wheel"
        type = "revolute"
        parent = "ground"
        axis = [0, 0, 1]
        rate = 10.0
        [[bodies]]
        name = "disc"
        node = "wheel"
        mass = 1.0
        inertia = [1.0, 1.0, 2.0]
        [[probes]]
        name = "turn"
        quantity = "rotation"
        node = "wheel"
        component = "z"
        [analysis.dynamic]
        to = 3.0
        step = 0.01
    "#;
    let mut motion = Motion::new(assemble_text("wheel.toml", text).unwrap()).unwrap();
    while motion.step().unwrap() {}
    let turn = motion.probe("turn").unwrap()[0];
    assert!((turn - 30.0).abs() < 1e-9, "{turn}");
}

#[test]
fn unknown_names_and_static_models_are_refused() {
    let mut motion = pendulum();
    let said = motion.probe("angel").unwrap_err().to_string();
    assert!(said.starts_with("there is no probe named \"angel\"; there are: angle, bob"));
    let said = motion.set_input("torque", 1.0).unwrap_err().to_string();
    assert!(
        said.starts_with("there is no input named \"torque\""),
        "{said}"
    );
    let text = read("examples/models/cantilever.toml");
    let refused = Motion::new(assemble_text("cantilever.toml", &text).unwrap());
    assert!(matches!(refused, Err(MotionError::Static)));
}
