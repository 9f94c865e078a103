//! One model, several contexts: in threads, and continued from a snapshot.

use super::mass_on_rail;
use crate::support::dynamics::motion_of;
use crate::support::prelude::*;
use crate::support::program::example;
use std::sync::Arc;

/// Mechanisms whose loops change their split, and beams that turn beyond their first chart.
const MODELS: [&str; 2] = ["four_bar_flexible", "top_beam"];
const STEPS: usize = 60;

/// The state after some more steps, bit by bit.
fn steps(run: &mut Simulation<&mut Context>) -> Vec<u64> {
    for _ in 0..STEPS {
        assert!(run.step().unwrap().is_some());
    }
    let State { q, v, a, .. } = run.state();
    let all = q.iter().chain(v).chain(a);
    all.map(|x| x.to_bits()).collect()
}

#[test]
fn a_model_is_shared_between_threads() {
    fn shared<T: Clone + Send + Sync>() {}
    shared::<Model>();
    shared::<Context>();
    for name in MODELS {
        let (mut context, first, options) = motion_of(&example(name));
        let model = Arc::clone(context.model());
        let run = |context: &mut Context| {
            steps(&mut Simulation::new(context, first.clone(), &options).unwrap())
        };
        let alone = run(&mut context);
        std::thread::scope(|scope| {
            let other = || run(&mut Context::new(Arc::clone(&model)));
            let threads = [scope.spawn(other), scope.spawn(other)];
            for thread in threads {
                assert!(thread.join().unwrap() == alone);
            }
        });
    }
}

#[test]
fn steps_from_a_snapshot_are_the_same_to_the_last_bit() {
    for name in MODELS.into_iter().chain(["free_body"]) {
        let (mut context, first, mut options) = motion_of(&example(name));
        if name == "free_body" {
            options.scheme = "projected-newmark".parse().unwrap();
        }
        let model = Arc::clone(context.model());
        let mut run = Simulation::new(&mut context, first, &options).unwrap();
        let before = steps(&mut run);
        let snapshot = run.save();
        let accelerations = run.system().configuration()[2].to_vec();
        let once = steps(&mut run);
        assert!(once != before);
        run.restore(&snapshot).unwrap();
        assert_eq!(run.system().configuration()[2], accelerations);
        assert!(steps(&mut run) == once);
        // In a new context with a clone of the state.
        let mut other = Context::new(model);
        assert!(other.set_state(snapshot.system.state().clone()));
        let mut run = Simulation::resume(&mut other, snapshot.progress, &options).unwrap();
        assert!(steps(&mut run) == once);
    }
}

/// A unit mass under a force that is an input, 0.5 at first.
fn pushed_mass() -> (Model, Input) {
    let (mut builder, node) = mass_on_rail();
    let force = builder.input(0.5);
    let load = NodalLoad::new(LoadKind::DeadForce, [1.0, 0.0, 0.0], force);
    builder.element("force", load, &[node]).unwrap();
    (builder.build().unwrap(), force)
}

/// The mass in two threads: x = ½ u t².
#[test]
fn inputs_are_part_of_the_state() {
    let (model, force) = pushed_mass();
    let model = Arc::new(model);
    let run = |u: f64| {
        let mut context = Context::new(Arc::clone(&model));
        context.set_input(force, u);
        let first = start(&context, 0.0, &[0.0], &[0.0]).unwrap();
        let options = DynamicOptions::new(1.0, 0.1);
        let mut run = Simulation::new(&mut context, first, &options).unwrap();
        let snapshot = run.save();
        run.set_input(force, -u);
        run.finish().unwrap();
        assert!((run.state().q[0] + 0.5 * u).abs() < 1e-13, "{u}");
        run.restore(&snapshot).unwrap();
        run.finish().unwrap();
        assert_eq!(run.system().input(force), u);
        run.state().q[0] - 0.5 * u
    };
    std::thread::scope(|scope| {
        for thread in [1.0, -3.0].map(|u| scope.spawn(move || run(u))) {
            assert!(thread.join().unwrap().abs() < 1e-13);
        }
    });
    assert_eq!(Context::new(model).input(force), 0.5);
}

/// A set point that is moved ahead of the motion is reached again.
#[test]
fn events_read_inputs_that_change() {
    let (mut builder, _) = mass_on_rail();
    let set_point = builder.input(0.5);
    let mut context = Context::new(builder.build().unwrap());
    let first = start(&context, 0.0, &[0.0], &[1.0]).unwrap();
    let options = DynamicOptions::new(2.0, 0.3);
    let mut run = Simulation::new(&mut context, first, &options).unwrap();
    run.add_event(
        move |context, state| state.q[0] - context.input(set_point),
        |_, _| ControlFlow::Continue(()),
    );
    let mut times = Vec::new();
    while let Some(step) = run.step().unwrap() {
        times.extend(step.events.iter().map(|_| step.progress.state.t));
        if run.state().t > 0.7 {
            run.set_input(set_point, 1.3);
        }
    }
    let [first, second] = times[..] else {
        panic!("{times:?}");
    };
    assert!((first - 0.5).abs() < 1e-11 && (second - 1.3).abs() < 1e-11);
}

/// An effect that leaves no numbers is refused as a whole: the input that it has set, too.
#[test]
fn refused_effects_leave_inputs_as_they_were() {
    let (model, force) = pushed_mass();
    let mut context = Context::new(model);
    context.set_input(force, 0.0);
    let first = start(&context, 0.0, &[0.0], &[1.0]).unwrap();
    let options = DynamicOptions::new(1.0, 0.1);
    let mut run = Simulation::new(&mut context, first, &options).unwrap();
    run.add_event(
        |_, state| state.q[0] - 0.55,
        move |context, state| {
            context.set_input(force, 3.0);
            state.v[0] = f64::NAN;
            ControlFlow::Continue(())
        },
    );
    for _ in 0..2 {
        assert!(run.finish().is_err());
        assert_eq!(run.system().input(force), 0.0);
        assert!((run.state().t - 0.55).abs() < 1e-9);
    }
}

#[test]
fn a_state_of_another_model_is_refused() {
    let [mut context, other] = MODELS.map(|name| motion_of(&example(name)).0);
    assert!(!context.set_state(other.state().clone()));
    // Nor is one of the same file built again: its charts may be any.
    let again = motion_of(&example(MODELS[0])).0;
    assert!(!context.set_state(again.state().clone()));
    assert!(context.set_state(context.state().clone()));
    // Nor numbers of which some fit: nothing changes.
    let saved = context.save();
    let (mut moved, first, options) = motion_of(&example(MODELS[0]));
    steps(&mut Simulation::new(&mut moved, first, &options).unwrap());
    let mut wrong = moved.save();
    wrong.maps.last_mut().unwrap().push(0.0);
    assert!(!context.restore(&wrong));
    assert_eq!(context.save(), saved);
}
