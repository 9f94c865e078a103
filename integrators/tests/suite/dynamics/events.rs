//! Events of a run: located, applied, repeated, saved.

use crate::support::dynamics::*;
use crate::support::*;
use std::f64::consts::PI;
use std::ops::ControlFlow::{self, Break, Continue};
use std::sync::{Arc, Mutex};

/// A run from a position and a velocity.
fn begun<'a, Y: System>(
    system: &'a mut Y,
    [q, v]: [f64; 2],
    options: &DynamicOptions,
) -> Simulation<&'a mut Y> {
    let state = start(system, 0.0, &[q], &[v]).unwrap();
    Simulation::new(system, state, options).unwrap()
}

/// The times of all events to the end of a run.
fn times<Y: System>(run: &mut Simulation<&mut Y>) -> Vec<(usize, f64)> {
    let mut all = Vec::new();
    while let Some(step) = run.step().unwrap() {
        let t = step.progress.state.t;
        all.extend(step.events.iter().map(|k| (*k, t)));
    }
    all
}

fn close(found: &[(usize, f64)], exact: &[(usize, f64)], tolerance: f64) {
    assert_eq!(found.len(), exact.len(), "{found:?}");
    for (found, exact) in found.iter().zip(exact) {
        let near = (found.1 - exact.1).abs() <= tolerance;
        assert!(found.0 == exact.0 && near, "{found:?} for {exact:?}");
    }
}

fn onward<Y>(_: &mut Y, _: &mut State) -> ControlFlow<()> {
    Continue(())
}

#[test]
fn a_load_is_released_where_the_mass_passes() {
    // x = 3 t²/2 until x = 1, then at the speed √6.
    let (t1, v1) = ((2.0_f64 / 3.0).sqrt(), 6.0_f64.sqrt());
    let implicit = ["radau", "bathe", "projected-newmark"];
    let more = implicit
        .into_iter()
        .chain(["central-difference", "tsitouras"]);
    let more = more.map(|word| word.parse::<Scheme>().unwrap());
    let steps = |scheme| steps_of(scheme, 2.0, 0.1);
    let equal = schemes().into_iter().chain(more);
    let adapted = [Scheme::default(), Scheme::tsitouras()];
    let adapted = adapted.map(|scheme| adaptive(steps(scheme), 1e-5, 0.3));
    for options in equal.map(steps).chain(adapted) {
        let (mut system, name) = (Oscillator::mass(3.0), options.scheme.name);
        let mut run = begun(&mut system, [0.0; 2], &options);
        let release = run.add_event(
            |_, state| state.q[0] - 1.0,
            |system, _| {
                system.force = 0.0;
                Continue(())
            },
        );
        close(&times(&mut run), &[(release, t1)], 1e-12);
        let end = run.state();
        assert!(end.t == 2.0 && end.a[0].abs() < 1e-12, "{name}");
        assert!((end.v[0] - v1).abs() < 1e-11, "{name}");
        let exact = 1.0 + v1 * (2.0 - t1);
        assert!((end.q[0] - exact).abs() < 1e-11, "{name}");
        let energy = run.progress().summary.energy.unwrap();
        assert!(energy.largest_defect < 1e-12, "{energy:?}");
    }
}

#[test]
fn a_run_stops_where_a_pendulum_is_lowest() {
    // A quarter of the period, K(sin ½)/ω, by the mean of Gauss.
    let mut system = Pendulum::new();
    let (mut a, mut b) = (1.0_f64, 0.5_f64.cos());
    for _ in 0..6 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    let quarter = std::f64::consts::FRAC_PI_2 / (a * system.g.sqrt());
    for (scheme, h) in [(Scheme::radau(), 0.001), (Scheme::tsitouras(), 0.01)] {
        let mut run = begun(&mut system, [1.0, 0.0], &steps_of(scheme, 2.0, h));
        run.add_event(|_, state| -state.q[0], |_, _| Break(()));
        run.finish().unwrap();
        let state = run.state();
        assert!((state.t - quarter).abs() < 1e-10, "{} {quarter}", state.t);
        assert!(state.q[0].abs() < 1e-10);
        assert!(!run.progress().summary.finished && run.step().unwrap().is_none());
        // It may be continued from there.
        let stopped = run.save();
        run.restore(&stopped).unwrap();
        assert!(run.step().unwrap().is_some());
    }
}

/// A ball that falls to the floor at 0 and leaves it at half its speed.
fn bounce(run: &mut Simulation<&mut Oscillator>) -> usize {
    run.add_event(
        |_, state| -state.q[0],
        |_, state| {
            state.v[0] *= -0.5;
            state.a.clear();
            Continue(())
        },
    )
}

#[test]
fn a_ball_bounces_also_within_a_step() {
    // It falls 1.25 m in 0.5 s, and its flights take 0.5 s, 0.25 s, ...: the last is far below a step.
    fn sent<T: Send>(_: &T) {}
    let mut system = Oscillator::mass(-10.0);
    let mut run = begun(&mut system, [1.25, 0.0], &DynamicOptions::new(2.0, 0.1));
    bounce(&mut run);
    sent(&run);
    let exact: Vec<_> = (0..20).map(|k| (0, 1.5 - 0.5_f64.powi(k))).collect();
    let mut found = Vec::new();
    while found.len() < exact.len() {
        let step = run.step().unwrap().expect("a bounce");
        let t = step.progress.state.t;
        found.extend(step.events.iter().map(|k| (*k, t)));
    }
    close(&found, &exact, 1e-11);
    let energy = run.progress().summary.energy.unwrap();
    assert!(energy.largest_defect < 1e-10, "{energy:?}");
}

#[test]
fn steps_across_events_are_saved_and_restored() {
    let damped = Scheme::chung_hulbert(0.5).unwrap();
    let schemes = [Scheme::default(), damped, Scheme::tsitouras()];
    let equal = schemes.map(|scheme| steps_of(scheme, 0.9, 0.07));
    for options in equal
        .into_iter()
        .chain(equal.map(|o| adaptive(o, 1e-5, 0.2)))
    {
        // On a spring, the accelerations of a damped scheme are not those of the equation of motion.
        let mut system = Oscillator {
            k: 3.0,
            ..Oscillator::mass(-10.0)
        };
        let mut run = begun(&mut system, [1.25, 0.0], &options);
        bounce(&mut run);
        let mut snapshots = vec![run.save()];
        while run.step().unwrap().is_some() {
            snapshots.push(run.save());
        }
        let end = run.progress().clone();
        for snapshot in &snapshots {
            run.set_step(0.3 * options.step).unwrap();
            run.restore(snapshot).unwrap();
            run.finish().unwrap();
            assert_eq!(*run.progress(), end);
        }
        // In another simulation, which has the same events.
        let half = &snapshots[snapshots.len() / 2];
        let mut other = half.system.clone();
        let mut run = Simulation::resume(&mut other, half.progress.clone(), &options).unwrap();
        bounce(&mut run);
        run.finish().unwrap();
        assert_eq!(*run.progress(), end);
    }
}

#[test]
fn events_at_the_end_of_a_step_and_several_in_one_step() {
    // At the speed 1, x = t. The times of the first three are ends of steps, one by a rounding error late.
    let at = [0.3, 0.1 + 0.2, 1.0, 0.35, 0.37, 0.37 + 1e-10, 0.55, 0.551];
    let mut system = Oscillator::mass(0.0);
    system.kinks = vec![0.55];
    let mut run = begun(&mut system, [0.0, 1.0], &DynamicOptions::new(1.0, 0.1));
    for (k, at) in at.into_iter().enumerate() {
        // Scales of values do not matter.
        let scale = 1e3_f64.powi(k as i32 % 5 - 2);
        run.add_event(move |_, state| scale * (state.q[0] - at), onward);
    }
    let order = [0, 1, 3, 4, 5, 6, 7, 2];
    let exact = order.map(|k| (k, at[k]));
    // An event that follows within 1e-8 of a step comes as much later.
    close(&times(&mut run), &exact, 1.1e-9);
    let found = run.progress();
    assert!((found.state.q[0] - 1.0).abs() < 1e-14, "{:?}", found.state);
}

#[test]
fn an_event_at_its_own_location_occurs_once() {
    // Its value stays at zero, or just below it; or the mass is set back.
    for (back, exact) in [
        (0.0, vec![(0, 1.0)]),
        (1e-12, vec![(0, 1.0)]),
        (1.0, vec![(0, 1.0), (0, 2.0), (0, 3.0)]),
    ] {
        let mut system = Oscillator::mass(0.0);
        let mut run = begun(&mut system, [0.0, 1.0], &DynamicOptions::new(3.5, 0.3));
        let effect = move |_: &mut Oscillator, state: &mut State| {
            state.q[0] -= back;
            Continue(())
        };
        run.add_event(|_, state| state.q[0] - 1.0, effect);
        // Zero at the start is no crossing.
        run.add_event(|_, state| state.q[0], onward);
        let found: Vec<_> = times(&mut run).into_iter().filter(|e| e.0 == 0).collect();
        close(&found, &exact, 1e-11);
    }
}

#[test]
fn a_value_that_almost_reaches_zero_does_not_lengthen_steps() {
    // Thrown up, the mass is 0.5 m high after 1 s.
    for (height, exact) in [
        (0.5001, vec![]),
        (0.5 + 1e-9, vec![]),
        (0.4999, vec![(0, 1.0 - 2e-4_f64.sqrt())]),
    ] {
        let mut system = Oscillator::mass(-1.0);
        let mut run = begun(&mut system, [0.0, 1.0], &DynamicOptions::new(2.0, 0.1));
        run.add_event(move |_, state| state.q[0] - height, onward);
        let mut found = Vec::new();
        while let Some(step) = run.step().unwrap() {
            assert!(step.step_size < 0.1 * 1.02, "{}", step.step_size);
            let t = step.progress.state.t;
            found.extend(step.events.iter().map(|k| (*k, t)));
        }
        close(&found, &exact, 1e-11);
        let summary = run.progress().summary;
        let [steps, evaluations] = [summary.steps, summary.evaluations];
        assert!(steps < 25 && evaluations < 200, "{steps}, {evaluations}");
    }
}

/// cos t crosses zero at odd multiples of π/2, after first steps that are far too small and at times with few digits.
#[test]
fn every_crossing_occurs_once() {
    let first = |step| adaptive(steps_of(Scheme::tsitouras(), 20.0, step), 1e-9, 0.5);
    let equal = DynamicOptions::new(1e7 + 20.0, 0.01);
    for (options, from) in [(first(1e-8), 0.0), (first(1e-6), 0.0), (equal, 1e7)] {
        let mut system = Oscillator::new(1.0, 1.0);
        system.kinks.clear();
        let state = start(&system, from, &[1.0], &[0.0]).unwrap();
        let mut run = Simulation::new(&mut system, state, &options).unwrap();
        run.add_event(|_, state| -state.q[0], onward);
        run.add_event(|_, state| state.q[0], onward);
        let exact = (0..6).map(|k| (k % 2, from + (k as f64 + 0.5) * PI));
        close(&times(&mut run), &exact.collect::<Vec<_>>(), 1e-2);
    }
}

/// Two events at x = 1: the second one finds the system where the first one puts it.
#[test]
fn effects_find_the_system_at_their_state() {
    let mut system = Configured::new(Oscillator::mass(0.0));
    let mut run = begun(&mut system, [0.0, 1.0], &DynamicOptions::new(2.0, 0.3));
    for _ in 0..2 {
        run.add_event(
            |_, state| state.q[0] - 1.0,
            |system: &mut Configured<Oscillator>, state| {
                assert_eq!(system.q, state.q);
                state.q[0] -= 3.0;
                Continue(())
            },
        );
    }
    close(&times(&mut run), &[(0, 1.0), (1, 1.0)], 1e-12);
}

/// A ball that keeps 0.99 of its speed comes to rest after 99.5 s, in ever shorter flights.
#[test]
fn events_without_end_are_refused() {
    let mut system = Oscillator::mass(-10.0);
    let mut run = begun(&mut system, [1.25, 0.0], &DynamicOptions::new(101.0, 0.1));
    run.add_event(
        |_, state| -state.q[0],
        |_, state| {
            state.v[0] *= -0.99;
            Continue(())
        },
    );
    let few = "events: expected fewer than 1000 short steps in a row";
    refused! { run.finish() => [few, "events [0] once more"] }
    assert!((run.state().t - 99.5).abs() < 0.1, "{}", run.state().t);
}

#[test]
fn an_impact_takes_a_value_across_zero() {
    // The velocity jumps from −5 to 2.5: an event of its own, just behind. At the top it falls again.
    let mut system = Oscillator::mass(-10.0);
    let mut run = begun(&mut system, [1.25, 0.0], &DynamicOptions::new(0.8, 0.1));
    bounce(&mut run);
    let record = Arc::new(Mutex::new(Vec::new()));
    let log = Arc::clone(&record);
    run.add_event(
        |_, state| state.v[0],
        move |_, state| {
            log.lock().unwrap().push((1, state.t));
            Continue(())
        },
    );
    run.add_event(|_, state| -state.v[0], onward);
    let found = times(&mut run);
    close(&found, &[(0, 0.5), (1, 0.5), (2, 0.75)], 1.1e-9);
    assert_eq!(*record.lock().unwrap(), found[1..2]);
}

#[test]
fn a_value_that_is_no_number_is_refused() {
    let mut system = Oscillator::mass(0.0);
    let options = DynamicOptions::new(1.0, 0.25);
    let mut run = begun(&mut system, [0.0, 1.0], &options);
    run.add_event(|_, state| (0.5 - state.q[0]).sqrt() - 2.0, onward);
    let value = "value of an event: expected a finite number, got NaN of event 0";
    refused! { run.finish() => ["step 3", value] }
    // Nor does an effect change the number of coordinates or the time, or leave no numbers; nor is the event passed over.
    type Change = (fn(&mut State), &'static str);
    let effects: [Change; 3] = [
        (|state| state.v.clear(), "velocities to begin with: 0 given"),
        (
            |state| state.v[0] = f64::NAN,
            "velocities to begin with: the mass is NaN",
        ),
        (|state| state.t = 0.0, "time after an event: expected 0.5"),
    ];
    for (change, said) in effects {
        let mut system = Oscillator::mass(0.0);
        let mut run = begun(&mut system, [0.0, 1.0], &options);
        let effect = move |_: &mut Oscillator, state: &mut State| {
            change(state);
            Continue(())
        };
        run.add_event(|_, state| state.q[0] - 0.5, effect);
        for _ in 0..2 {
            refused! { run.finish() => [said] }
            assert_eq!(run.state().v, [1.0]);
            assert!((run.state().t - 0.5).abs() < 1e-6, "{}", run.state().t);
        }
    }
}

/// A mass at the speed 1 for a second that goes on at 2 from the same position, or from another one: what was kept of the
/// events and of the invariants belongs to the motion before.
#[test]
fn a_state_that_is_changed_starts_anew() {
    for word in ["newmark", "projected-newmark", "radau"] {
        for (position, exact) in [(1.0, vec![(0, 1.25)]), (1.75, vec![])] {
            let mut system = Oscillator::mass(0.0);
            let mut options = steps_of(Scheme::named(word, &[]).unwrap(), 1.0, 0.1);
            let mut run = begun(&mut system, [0.0, 1.0], &options);
            run.add_event(|_, state| state.q[0] - 1.5, onward);
            run.finish().unwrap();
            let mut progress = run.progress().clone();
            let state = &mut progress.state;
            (state.q[0], state.v[0]) = (position, 2.0);
            state.a.clear();
            state.algorithmic.clear();
            options.to = 2.0;
            let mut run = Simulation::resume(&mut system, progress, &options).unwrap();
            run.add_event(|_, state| state.q[0] - 1.5, onward);
            close(&times(&mut run), &exact, 1e-12);
            let end = position + 2.0 - run.state().q[0];
            assert!(end.abs() < 1e-12, "{word}: {:?}", run.state());
        }
    }
}
