//! Motions of model files step by step.

use crate::support::*;
use pullback::input::assemble_text;
use pullback::motion::{Motion, MotionError};

fn pendulum() -> Motion {
    started(&example("pendulum")).unwrap()
}

fn started(text: &str) -> Result<Motion, MotionError> {
    Motion::new(assemble_text("model.toml", text).unwrap())
}

/// The probes of each step are those of a run of the program.
#[test]
fn steps_are_those_of_a_run() {
    let mut motion = pendulum();
    for row in recorded("motion", &example("pendulum")) {
        assert_eq!(motion.state().t, number(&row, "t"));
        for (probe, columns) in [
            ("angle", &["angle"][..]),
            ("tension", &["tension"]),
            ("support", &["support"]),
            ("energy", &["energy"]),
            ("bob", &["bob.x", "bob.y", "bob.z"]),
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
    for none in [f64::NAN, 0.0] {
        let refused = motion.set_step(none);
        assert!(matches!(refused, Err(MotionError::Dynamics(_))), "{none}");
    }
    assert!(motion.step().unwrap());
}

/// A rotation about a fixed axis counts its turns, whether or not its probe is read at each step.
#[test]
fn turns_are_counted_between_readings() {
    let text = [
        GROUND,
        &hinge("wheel", "ground", "rate = 10.0"),
        &body_of("wheel", 1.0, "inertia = [1.0, 1.0, 2.0]"),
        &probe("turn", "rotation", "wheel"),
        "component = \"z\"\n[analysis.dynamic]\nto = 3.0\nstep = 0.01\n",
    ];
    let mut motion = started(&text.concat()).unwrap();
    while motion.step().unwrap() {}
    let turn = motion.probe("turn").unwrap()[0];
    assert_close(turn, 30.0, 1e-9, "turn");
}

/// A crank that an input moves takes its linkage along, without a velocity, also where multipliers close it.
#[test]
fn an_input_moves_a_loop_at_rest() {
    for closure in &CLOSURES[..2] {
        for scheme in ["\"radau\"", "\"bathe\"", "{ generalised-alpha = 0.8 }"] {
            let text = [
                GROUND,
                "[inputs]\nu = 0\n",
                &four_bar(["prescribed = { input = \"u\" }", "", ""], closure),
                &probe_of("energy", "kinetic_energy", ""),
                &motion(0.1, 0.01),
                &format!("scheme = {scheme}\n"),
            ];
            let mut run = started(&text.concat()).unwrap();
            for u in [0.05, 0.3, -0.2] {
                run.set_input("u", u).unwrap();
                run.step().unwrap();
                let [b, d] = linkage(u);
                for (probe, exact) in [("A", u), ("B", b), ("D", d), ("energy", 0.0)] {
                    let found = run.probe(probe).unwrap()[0];
                    assert_close(
                        found,
                        exact,
                        1e-11,
                        format_args!("{closure} {scheme}: {probe}"),
                    );
                }
            }
        }
    }
}

/// A rocker cannot be turned by 3 rad: its motion goes on from where it was once the input is within reach.
#[test]
fn an_input_out_of_reach_leaves_a_loop_as_it_was() {
    let text = [
        GROUND,
        "[inputs]\nu = 0\n",
        &four_bar(["", "", "prescribed = { input = \"u\" }"], CLOSURES[1]),
        &motion(0.1, 0.01),
    ];
    let mut run = started(&text.concat()).unwrap();
    run.set_input("u", 3.0).unwrap();
    run.step().unwrap_err();
    let [_, rocker] = linkage(0.05);
    run.set_input("u", rocker).unwrap();
    run.step().unwrap();
    assert_close(run.probe("A").unwrap()[0], 0.05, 1e-9, "crank");
}

#[test]
fn unknown_names_and_static_models_are_refused() {
    let mut motion = pendulum();
    let said = motion.probe("angel").unwrap_err().to_string();
    assert!(said.starts_with("there is no probe named \"angel\"; there are: angle, bob"));
    let said = motion.set_input("torque", 1.0).unwrap_err().to_string();
    assert_says(&said, &["there is no input named \"torque\""]);
    let refused = started(&example("cantilever"));
    assert!(matches!(refused, Err(MotionError::Static)));
}
