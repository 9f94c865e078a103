//! Elements whose ends turn against each other by more than half a turn: about the common axis all
//! laws are linear, so that everything is known in closed form up to a whole turn. Beyond it no pair
//! of rotation vectors tells what the ends have done, and the answer is an error.

use crate::support::beams::straight;
use crate::support::dynamics::*;
use crate::support::prelude::*;
use crate::support::program::assert_close;
use Interpolation::{Geodesic, Total};
use nalgebra::Matrix6;

/// Torsional stiffness GJ, and moment per angle of the bushing.
const GJ: f64 = 0.7;

#[derive(Clone, Copy, Debug, PartialEq)]
enum By {
    /// This many beam elements of this order.
    Beams(Interpolation, usize, usize),
    Bushing,
}

/// A shaft of length 1 along e1 from `root` to `tip`; the tip may slide and turn about e1 only.
fn shaft(by: By) -> (ModelBuilder, NodeId, NodeId) {
    let mut b = ModelBuilder::new();
    let positions = [Vector3::zeros(), Vector3::x()];
    let root = b.node("root", positions[0].into()).unwrap();
    let tip = b.node("tip", positions[1].into()).unwrap();
    match by {
        By::Beams(interpolation, elements, order) => {
            let axis = straight(&b, [root, tip]);
            let section = Section::diagonal(1e3, [1e3; 2], GJ, [0.5; 2]).unwrap();
            let line = BeamLine {
                order,
                interpolation,
                ..BeamLine::new(elements, section)
            };
            b.line("shaft", &axis, [root, tip], &line).unwrap();
        }
        By::Bushing => {
            let K = Matrix6::from_diagonal(&[1e3, 1e3, 1e3, GJ, 0.5, 0.5].into());
            let bushing =
                Bushing::new(&positions, &Matrix3::identity(), &K, &Matrix6::zeros()).unwrap();
            b.element("bushing", bushing, &[root, tip]).unwrap();
        }
    }
    b.support(tip, &[Dof::Y, Dof::Z, Dof::RY, Dof::RZ]);
    (b, root, tip)
}

/// Turns the root by `base` and the tip by `base + twist` and gives the energy stored.
fn energy(by: By, base: f64, twist: f64, steps: usize) -> Result<f64, StaticsError> {
    let (mut b, root, tip) = shaft(by);
    b.support(root, &[Dof::X, Dof::Y, Dof::Z, Dof::RY, Dof::RZ]);
    b.prescribe(root, Dof::RX, Proportional(base));
    b.prescribe(tip, Dof::RX, Proportional(base + twist));
    let mut context = Context::new(b.build().unwrap());
    equilibrium(&mut context, &StaticOptions::equal_steps(steps))?;
    Ok(context.strain_energy(1.0))
}

const SHAFTS: [By; 7] = [
    By::Beams(Total, 1, 1),
    By::Beams(Total, 1, 2),
    By::Beams(Total, 1, 3),
    By::Beams(Geodesic, 1, 1),
    By::Beams(Geodesic, 1, 2),
    By::Beams(Geodesic, 1, 3),
    By::Bushing,
];

#[test]
fn a_driven_end_twists_one_element_by_nearly_a_turn() {
    for by in SHAFTS {
        for twist in [2.5, PI, 4.0, -5.0, 6.0] {
            // The structure may turn as a whole, by any number of turns.
            for base in [0.0, 3.0, -20.0] {
                for steps in [4, 9, 40] {
                    let found = energy(by, base, twist, steps).unwrap();
                    let exact = 0.5 * GJ * twist * twist;
                    let what = format!("{by:?}, {twist} rad on {base} rad in {steps} steps");
                    assert_close(found, exact, 1e-12 * exact, what);
                }
            }
        }
    }
}

#[test]
fn beyond_a_turn_the_error_names_the_element() {
    for (by, name) in [
        (By::Beams(Total, 1, 1), "shaft:1"),
        (By::Beams(Total, 1, 2), "shaft:1"),
        (By::Beams(Geodesic, 1, 1), "shaft:1"),
        (By::Beams(Geodesic, 1, 2), "shaft:1"),
        (By::Bushing, "bushing"),
    ] {
        for base in [0.0, 0.5, 7.0, -11.0] {
            for steps in [1, 3, 30] {
                let outcome = energy(by, base, 8.0, steps);
                let Err(error) = outcome else {
                    panic!("{by:?}, {base} rad in {steps} steps: {outcome:?}");
                };
                let error = error.to_string();
                assert!(error.contains(name), "{error}");
                // Three geodesic nodes are seen from the middle one, by half the twist: there the
                // tip's own vector may come to its edge first.
                let own = by == By::Beams(Geodesic, 1, 2)
                    && error.contains("the range of its coordinates");
                assert!(own || error.contains("take more elements"), "{error}");
            }
        }
    }
    // Two elements share the turn.
    let found = energy(By::Beams(Total, 2, 1), 7.0, 8.0, 30).unwrap();
    assert!((found - 0.5 * GJ * 64.0).abs() < 1e-12 * found);
}

#[test]
fn a_motion_ends_before_a_turn_whatever_its_steps() {
    for by in [SHAFTS[0], SHAFTS[3], By::Bushing] {
        // The last of few steps ends beyond a turn.
        for steps in [10, 500] {
            let (mut b, root, tip) = shaft(by);
            b.support(root, &Dof::ALL);
            b.prescribe(tip, Dof::RX, Proportional(6.6));
            let disk = RigidBody::new(1.0, Matrix3::identity(), Vector3::zeros()).unwrap();
            b.element("disk", disk, &[tip]).unwrap();
            let mut context = Context::new(b.build().unwrap());
            let mut progress = Progress::new(start(&context, 0.0, &[], &[]).unwrap());
            let options = tight(Scheme::default(), 1.0, 1.0 / f64::from(steps));
            let observe = &mut |context: &mut Context, step: &StepReport<'_>| {
                let state = &step.progress.state;
                configure(context, state);
                let exact = 0.5 * GJ * (6.6 * state.t).powi(2);
                assert_close(
                    context.strain_energy(state.t),
                    exact,
                    1e-12,
                    format!("{by:?}"),
                );
                ControlFlow::Continue(())
            };
            let ended = integrate(&mut context, &mut progress, &options, observe);
            let error = ended.unwrap_err().to_string();
            assert!(error.contains("take more elements"), "{by:?}: {error}");
        }
    }
}

#[test]
fn a_disk_swings_by_nearly_a_turn_on_one_element() {
    // J θ̈ = −GJ θ, through θ = ±5.5.
    let inertia = 0.9_f64;
    let omega = (GJ / inertia).sqrt();
    for by in [By::Beams(Total, 1, 1), By::Bushing] {
        let (mut b, root, tip) = shaft(by);
        b.support(root, &Dof::ALL);
        let disk = RigidBody::new(1.0, Matrix3::identity() * inertia, Vector3::zeros()).unwrap();
        b.element("disk", disk, &[tip]).unwrap();
        let mut context = Context::new(b.build().unwrap());
        let n = context.pattern().dim();
        let mut v = vec![0.0; n];
        v[context.unknown(tip, Dof::RX).unwrap()] = 5.5 * omega;
        let until = 1.3 * TAU / omega;
        let mut run = |steps: usize, stop: Option<usize>| {
            let options = tight(Scheme::default(), until, until / steps as f64);
            let mut progress = Progress::new(start(&context, 0.0, &vec![0.0; n], &v).unwrap());
            let mut errors = 0.0_f64;
            let mut go = |progress: &mut Progress, context: &mut Context| {
                integrate(context, progress, &options, &mut |context, step| {
                    let state = &step.progress.state;
                    configure(context, state);
                    let theta = 5.5 * (omega * state.t).sin();
                    let found = (2.0 * context.strain_energy(state.t) / GJ).sqrt();
                    errors = errors.max((found - theta.abs()).abs());
                    match stop == Some(step.progress.summary.steps) {
                        true => ControlFlow::Break(()),
                        false => ControlFlow::Continue(()),
                    }
                })
                .unwrap();
            };
            go(&mut progress, &mut context);
            if stop.is_some() {
                // Stopped in mid-swing, and another run has been made with the model since.
                let state = context.save();
                context.start(0.0, &vec![0.0; n]);
                assert!(context.restore(&state));
                go(&mut progress, &mut context);
            }
            errors
        };
        let errors = [100, 200, 400].map(|steps| run(steps, None));
        assert_order(format!("{by:?}"), &errors, 2.0, 0.05);
        // At the seventieth of 400 steps the disk has turned by 4.5 rad.
        assert_eq!(run(400, Some(70)), errors[2], "{by:?}");
    }
}

#[test]
fn a_bushing_between_frames_that_both_turn_many_times() {
    // Behind a driven shaft of angle W t a disk starts with the rate W + A ω: its angle is W t + A sin ωt.
    let (W, A, k, inertia, to) = (3.0, 2.0, 0.7, 0.1_f64, 6.0);
    let omega = (k / inertia).sqrt();
    let errors = [600, 1200, 2400].map(|n| {
        let (mut b, ground) = grounded();
        let [shaft, disk] =
            ["shaft", "disk"].map(|name| revolute(&mut b, name, ground, [1.0, 2.0, 2.0]));
        b.prescribe_coordinate(shaft.coordinates[0], 0, Proportional(W));
        let J = Matrix3::identity() * inertia;
        let body = RigidBody::new(1.0, J, Vector3::zeros()).unwrap();
        b.element("disk", body, &[disk.frame]).unwrap();
        let K = Matrix6::from_diagonal(&[1.0, 1.0, 1.0, k, k, k].into());
        let ends = [Vector3::zeros(); 2];
        let coupling = Bushing::new(&ends, &Matrix3::identity(), &K, &Matrix6::zeros()).unwrap();
        b.element("coupling", coupling, &[shaft.frame, disk.frame])
            .unwrap();
        let mut context = Context::new(b.build().unwrap());
        let options = tight(Scheme::default(), to, to / f64::from(n));
        let start = [&[0.0][..], &[W + A * omega]];
        let mut error = 0.0_f64;
        observed(&mut context, start, &options, &mut |context, step| {
            let t = step.progress.state.t;
            let [angle, ..] = context.coordinate(disk.coordinates[0], 0).unwrap();
            let turned = so3::rotation(&(Vector3::new(1.0, 2.0, 2.0) * (angle / 3.0)));
            assert!((context.node_state(disk.frame).R - turned).amax() < 1e-13);
            error = error.max((angle - W * t - A * (omega * t).sin()).abs());
        });
        error
    });
    assert!(W * to - A > 2.0 * TAU, "both turn more than twice");
    assert_order("bushing", &errors, 2.0, 0.05);
}
