//! Where a slide is handed over: exact motions of beads on polygons of wire.

use crate::support::dynamics::{heavy_body, observed, point, sine, tight};
use crate::support::landing::{G, MASS, Track, bead, bowl};
use crate::support::prelude::*;
use std::ops::ControlFlow::Continue;

/// Largest errors in position and speed of a bead that starts at s with speed v on its way to time `to`.
fn errors(track: &Track, [s, v]: [f64; 2], to: f64, h: f64) -> ([f64; 2], Progress) {
    let (mut model, beads) = track.model(&[s]);
    let mut worst = [0.0_f64; 2];
    let options = tight(Scheme::default(), to, h);
    let progress = observed(&mut model, [&[], &[v]], &options, &mut |model, step| {
        let t = step.progress.state.t;
        let exact = track.exact(s, v, t);
        let found = model.coordinate(beads[0].coordinates[0], 0).unwrap();
        worst[0] = worst[0].max((s + found[0] - exact[0]).abs());
        worst[1] = worst[1].max((found[1] - exact[1]).abs());
        let position = model.node_state(beads[0].frame).position - track.velocity * t;
        let off = (position - track.at(s + found[0])).norm();
        assert!(off < 1e-9, "{position} at {t}");
    });
    (worst, progress)
}

#[test]
fn a_driven_slide_bears_weight_and_inertia_of_its_mass() {
    // Three metres of seven sides in line.
    let slope = -0.6_f64.asin();
    let along = Vector3::new(slope.cos(), 0.0, slope.sin());
    let mut b = ModelBuilder::new();
    let nodes = Track::of(&[[3.0 / 7.0, slope]; 7]).nodes(&mut b, "wire");
    let bead = bead(&mut b, "bead", &nodes, 1.4);
    let drive = sine(1.1, 2.5, 0.0);
    b.prescribe_coordinate(bead.coordinates[0], 0, drive);
    // Something must be unknown.
    let free = b.node("free", [0.0; 3]).unwrap();
    heavy_body(&mut b, "free", free, 1.0, [0.0; 3]);
    let mut context = Context::new(b.build().unwrap());
    let mut changes = 0;
    let options = tight(Scheme::default(), 2.6, 0.013);
    observed(&mut context, [&[], &[]], &options, &mut |context, step| {
        let s = &step.progress.state;
        let forces = context.forces(point(s)).unwrap();
        let [force, moment] = forces.joint_force(bead.frame).unwrap();
        let [way, rate, second] = drive.at(s.t, &[]);
        let found = context.node_state(bead.frame);
        assert!((found.position - along * (1.4 + way)).norm() < 1e-13);
        assert!((found.velocity - along * rate).norm() < 1e-12);
        let exact = (along * second + Vector3::z() * G) * MASS;
        assert!((force - exact).norm() < 1e-11, "{force} {exact}");
        assert!(moment.norm() < 1e-12);
        changes += step.chart_changes;
    });
    // From 1.4 up to 2.5, down to 0.3 and back: two elements on, five back, three on.
    assert_eq!(changes, 10, "elements left behind");
}

#[test]
fn a_bead_that_turns_near_a_corner_turns_where_it_should() {
    // It climbs 0.4 m of the second side and turns so far behind its end, or before it, within a step.
    let track = bowl();
    let h = 0.01;
    let height = |s: f64| track.at(s).z;
    for beyond in [
        -1e-3, -1e-7, -1e-12, 0.0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 3e-4, 1e-3, 1e-2,
    ] {
        let v = (2.0 * G * (height(1.0 + beyond) - height(0.6))).sqrt();
        let (worst, run) = errors(&track, [0.6, v], 0.8, h);
        // A height known to a few units in its last position decides for how long it is on the next side.
        let excursion = 2.0 * (2.0_f64 * 1e-14 / 3.0).sqrt();
        let allowed = 1e-9 + 2.0 * excursion;
        let most = worst[0].max(worst[1]);
        assert!(most < allowed, "{beyond:e}: {worst:?}, allowed {allowed:e}");
        assert!(run.summary.steps < 80 + 12, "{beyond:e}: {:?}", run.summary);
    }
}

#[test]
fn a_bead_that_starts_on_a_corner_moves_either_way_or_rests() {
    let track = bowl();
    for v in [-3.0, -1e-3, -1e-9, 0.0, 1e-9, 1e-3, 3.0] {
        for corner in [0.5, 1.0] {
            let (worst, run) = errors(&track, [corner, v], 0.12, 0.01);
            assert!(worst[0].max(worst[1]) < 1e-9, "{v} at {corner}: {worst:?}");
            assert!(run.summary.steps < 12 + 6, "{v}: {}", run.summary.steps);
        }
    }
    // On a ridge it goes down one of the sides, in a valley it stays.
    let ridge = Track::of(&[[1.0, 0.4], [1.0, -0.7]]);
    let (worst, _) = errors(&ridge, [1.0, 0.0], 0.3, 0.01);
    assert!(worst[0].max(worst[1]) < 1e-9, "{worst:?}");
    let valley = Track::of(&[[1.0, -0.4], [1.0, 0.7]]);
    for h in [0.01, 0.001] {
        let (mut model, beads) = valley.model(&[1.0]);
        let mut worst = 0.0_f64;
        let options = tight(Scheme::default(), 0.5, h);
        let run = observed(&mut model, [&[], &[]], &options, &mut |m, _| {
            worst = worst.max(m.coordinate(beads[0].coordinates[0], 0).unwrap()[0].abs());
        });
        // A step of its weight at most, again and again.
        assert!(worst < 4.0 * 0.5 * G * h * h, "{worst:e}");
        let steps = run.summary.steps;
        assert!(steps < (60.0 * 0.5 / h) as usize, "{steps}");
    }
}

#[test]
fn a_bead_swings_in_a_valley() {
    // From slow swings to some that are faster than the steps.
    let track = Track::of(&[[1.0, -0.4], [1.0, 0.4]]);
    let h = 0.01;
    for v in [1.0, 0.1, 1e-2, 1e-3] {
        let (mut model, _) = track.model(&[1.0]);
        let mut worst = 0.0_f64;
        let options = tight(Scheme::default(), 1.0, h);
        let run = observed(&mut model, [&[], &[v]], &options, &mut |_, s| {
            let energy = |s: f64, v: f64| 0.5 * v * v + G * 0.4_f64.sin() * s.abs();
            let state = &s.progress.state;
            worst = worst.max((energy(state.q[0], state.v[0]) / energy(0.0, v) - 1.0).abs());
        });
        assert!(worst < 1e-6, "{v}: {worst:e}");
        // Twice for a swing, of 4 v / (g sin 0.4), and the steps between.
        let swings = G * 0.4_f64.sin() / (4.0 * v);
        let steps = run.summary.steps;
        assert!(steps as f64 <= 2.0 * swings + 102.0, "{v}: {steps}");
    }
}

#[test]
fn a_fast_bead_crosses_many_elements_in_a_step() {
    for sides in [40, 400] {
        let n = f64::from(sides);
        let shape: Vec<[f64; 2]> = (0..sides)
            .map(|k| [4.0 / n, -0.8 + 1.2 * (f64::from(k) + 0.5) / n])
            .collect();
        let track = Track::of(&shape);
        // The whole way in about eight steps, 5 or 50 elements each, and in one.
        for h in [0.01, 0.1] {
            let (worst, run) = errors(&track, [0.013, 50.0], 0.07, h);
            assert!(worst[0].max(worst[1]) < 1e-8, "{sides}, {h}: {worst:?}");
            assert!(run.summary.chart_changes > sides as usize * 8 / 10);
        }
    }
}

#[test]
fn a_moving_wire_is_a_wire_at_rest_to_who_moves_with_it() {
    for velocity in [Vector3::new(3.0, 0.0, 0.0), Vector3::new(-1.0, 2.0, 5.0)] {
        let track = Track { velocity, ..bowl() };
        let (worst, _) = errors(&track, [0.1, 4.0], 0.5, 0.01);
        assert!(worst[0].max(worst[1]) < 1e-9, "{worst:?}");
    }
}

#[test]
fn events_and_corners_share_a_step() {
    // At the speed 1 on a level wire: before its corner, on it, and behind it.
    let track = Track::of(&[[0.5, 0.0], [0.5, 0.0], [0.5, 0.0]]);
    let (mut context, beads) = track.model(&[0.2]);
    let state = start(&context, 0.0, &[], &[1.0]).unwrap();
    let options = tight(Scheme::default(), 1.0, 0.4);
    let mut run = Simulation::new(&mut context, state, &options).unwrap();
    let times = [0.25, 0.3, 0.35, 0.8];
    for time in times {
        let bead = beads[0].coordinates[0];
        let value = move |context: &Context, _: &State| {
            let arc_length = context.coordinate(bead, 0);
            arc_length.unwrap()[0] - time
        };
        run.add_event(value, |_, _| Continue(()));
    }
    let mut found = Vec::new();
    while let Some(step) = run.step().unwrap() {
        let t = step.progress.state.t;
        found.extend(step.events.iter().map(|k| (*k, t)));
    }
    for (k, (event, t)) in found.iter().enumerate() {
        assert!(*event == k && (t - times[k]).abs() < 1e-11, "{found:?}");
    }
    assert_eq!(found.len(), times.len());
    assert!((run.state().v[0] - 1.0).abs() < 1e-12);
}
