//! Several slides, closed rings, schemes of all families, adaptive steps, and failing steps, where slides
//! are handed over.

use crate::support::dynamics::{assert_order, observed, spring, tight};
use crate::support::landing::{G, Track, bead, bowl};
use crate::support::prelude::*;
use crate::support::program::{assert_close, assert_says};

#[test]
fn slides_on_one_chain_are_handed_over_one_right_after_another() {
    let track = bowl();
    let options = tight(Scheme::default(), 0.15, 0.01);
    for gap in [0.0, 1e-15, 1e-13, 1e-11, 1e-9, 1e-7, 1e-5, 1e-3, 1e-2] {
        // The third one comes the other way.
        let ways = [
            [0.2, 4.0],
            [0.2 - gap, 4.0],
            [1.3 + gap, -3.0],
            [0.2 - 2.0 * gap, 4.0],
        ];
        let (mut model, beads) = track.model(&ways.map(|way| way[0]));
        let mut v = vec![0.0; beads.len()];
        for (bead, way) in beads.iter().zip(ways) {
            assert!(model.set(&mut v, bead.coordinates[0], 0, way[1]));
        }
        let mut worst = 0.0_f64;
        let run = observed(&mut model, [&[], &v], &options, &mut |model, step| {
            for (bead, [s, v]) in beads.iter().zip(ways) {
                let found = model.coordinate(bead.coordinates[0], 0).unwrap();
                let exact = track.exact(s, v, step.progress.state.t);
                worst = worst.max((Vector2::new(s + found[0], found[1]) - exact).amax());
            }
        });
        assert!(worst < 1e-9, "{gap:e}: {worst:e}");
        assert!(run.summary.steps < 15 + 16, "{gap:e}: {:?}", run.summary);
    }
}

/// A ring of twelve elements in a vertical plane, a chain that goes round it `rounds` times.
fn ring(rounds: usize) -> (Context, JointNodes, Track) {
    let sides: Vec<[f64; 2]> = (0..12)
        .map(|k| [0.5, TAU * (f64::from(k) + 0.5) / 12.0])
        .collect();
    let once = Track::of(&sides);
    let mut b = ModelBuilder::new();
    let closed = Track {
        positions: once.positions[..12].to_vec(),
        ..Track::of(&[])
    };
    let nodes = closed.nodes(&mut b, "ring");
    let chain: Vec<NodeId> = (0..=12 * rounds).map(|k| nodes[k % 12]).collect();
    let bead = bead(&mut b, "bead", &chain, 0.0);
    (
        Context::new(b.build().unwrap()),
        bead,
        Track::of(&sides.repeat(rounds)),
    )
}

#[test]
fn a_slide_goes_round_a_closed_ring_as_often_as_its_chain_does() {
    // From the lowest point with enough for the highest, 1.93 m above: two rounds and a half.
    let (mut context, bead, track) = ring(3);
    let (mut energies, mut last) = (Vec::new(), 0.0);
    let options = tight(Scheme::default(), 1.6, 0.01);
    let from = [&[][..], &[11.0]];
    let run = observed(&mut context, from, &options, &mut |context, step| {
        let s = context.node_state(bead.frame);
        energies.push(0.5 * s.velocity.norm_squared() + G * s.position.z);
        last = context.coordinate(bead.coordinates[0], 0).unwrap()[0];
        let exact = track.exact(0.0, 11.0, step.progress.state.t);
        assert!((last - exact[0]).abs() < 1e-8, "{last} for {exact}");
    });
    assert!(last > 2.2 * 6.0, "{last}");
    assert!(run.summary.chart_changes >= 26);
    assert!(energies.iter().all(|e| (e / 60.5 - 1.0).abs() < 1e-10));
    // A chain that goes round once ends where it began, and says so.
    let (mut context, ..) = ring(1);
    let first = start(&context, 0.0, &[], &[11.0]).unwrap();
    let mut run = Simulation::new(&mut context, first, &options).unwrap();
    let error = run.finish().unwrap_err();
    let DynamicsError::Step(failed) = &error else {
        panic!("{error}");
    };
    let text = failed.to_string();
    assert!(text.contains("its chain of beams over an end"), "{text}");
    assert_says(&text, &["bead", "smallest step"]);
    assert!(failed.to - failed.from >= options.min_step, "{text}");
    let Cause::System(SystemError::Domain { what, why }) = &failed.cause else {
        panic!("{text}");
    };
    assert_eq!(what, "joint at node bead");
    assert!(matches!(why, DomainError::Beyond { margin, .. } if *margin <= 0.0));
    let failed = run.progress().summary.failed;
    assert!(failed < 30, "{failed}");
    assert_close(run.state().q[0], 6.0, 1e-4, "end of the chain");
}

/// A bead on a spring along a zigzag in a level plane: u = cos 2t whatever the corners.
fn sprung(sides: usize) -> (Context, JointNodes) {
    let length = 4.0 / sides as f64;
    let position = |k: usize| {
        let right = (length * 0.8) * k as f64;
        Vector3::new(right, length * 0.6 * (k % 2) as f64, 0.0)
    };
    let track = Track {
        positions: (0..=sides).map(position).collect(),
        ..Track::of(&[])
    };
    let mut b = ModelBuilder::new();
    let nodes = track.nodes(&mut b, "wire");
    let bead = bead(&mut b, "bead", &nodes, 2.0);
    spring(&mut b, 1.3 * 4.0, bead.coordinates[0]);
    (Context::new(b.build().unwrap()), bead)
}

#[test]
fn schemes_of_every_family_keep_their_order_over_landings() {
    let words = "newmark newmark:0.3025:0.6 hht:-0.1 wbz:0.8 ga:0.5 projected-newmark bathe radau central-difference \
                 tsitouras";
    for word in words.split(' ') {
        let scheme: Scheme = word.parse().unwrap();
        let to = 2.3_f64;
        let errors = [60.0, 120.0, 240.0].map(|n| {
            let (mut context, _) = sprung(9);
            let options = tight(scheme, to, to / n);
            let run = observed(&mut context, [&[1.0], &[]], &options, &mut |_, _| ());
            assert!(run.summary.chart_changes >= 6, "{:?}", run.summary);
            // No lost steps: those of the plain way, and what lands.
            assert!(run.summary.steps as f64 <= n + 2.0 * 12.0);
            let exact = [(2.0 * to).cos(), -2.0 * (2.0 * to).sin()];
            (run.state.q[0] - exact[0]).hypot(run.state.v[0] - exact[1])
        });
        assert_order(word, &errors, scheme.order() as f64, 0.25);
    }
}

#[test]
fn adaptive_steps_are_not_spoilt_by_landings() {
    let to = 6.0;
    let run = |sides: usize, tolerance: f64| {
        let (mut context, _) = sprung(sides);
        let options = DynamicOptions {
            adaptivity: Some(Adaptivity {
                tolerance,
                max_step: 0.5,
            }),
            energies: true,
            ..tight(Scheme::default(), to, 1e-3)
        };
        let mut booked = 0;
        let mut t = 0.0;
        let run = observed(&mut context, [&[1.0], &[]], &options, &mut |_, step| {
            booked += step.iterations;
            t += step.step_size;
            assert!((t - step.progress.state.t).abs() < 1e-12, "{t}");
        });
        let s = run.summary;
        assert_eq!(booked, s.iterations);
        assert!(s.evaluations > s.steps && s.factorisations >= s.steps);
        let error = (run.state.q[0] - (2.0 * to).cos()).abs();
        (error, s)
    };
    for tolerance in [1e-4, 1e-5, 1e-6, 1e-7] {
        // Two sides with the corner at the middle, many, and hardly any step without a landing.
        for sides in [2, 9, 101] {
            let ((plain, one), (error, many)) = (run(1, tolerance), run(sides, tolerance));
            let landings = many.chart_changes;
            assert!(landings as f64 > 0.15 * sides as f64 * to, "{landings}");
            let what = format!("{sides}, {tolerance:e}: {error:e} for {plain:e}");
            assert!(error < 1.5 * plain, "{what}");
            // A step in two, the rest of a step that others had begun with, and what smaller errors
            // before the next step cost.
            let most = one.steps + one.steps / 10 + 3 * landings;
            assert!(many.steps <= most, "{sides}: {} for {most}", many.steps);
            let (found, most) = (many.inaccurate, one.inaccurate + landings / 4 + 4);
            assert!(found <= most, "{sides}: {found} for {most}");
            assert!(many.energy.unwrap().largest_defect < 1e-9);
        }
    }
}
