//! A simulation inside another program: a joint with a digital controller, a snapshot, and events.

use nalgebra::Matrix3;
use pullback::Failure;
use pullback::elements::joint::Revolute;
use pullback::elements::load::CoordinateForce;
use pullback::elements::time::Input;
use pullback::prelude::*;
use std::ops::ControlFlow::{Break, Continue};

/// Moment of inertia about the axis, and the gains of the controller.
const INERTIA: f64 = 0.4;
const GAINS: [f64; 2] = [9.0, 2.5];
/// Sampling time, and number of samples.
const H: f64 = 0.02;
const SAMPLES: usize = 150;

/// A body on a revolute joint with a motor, whose torque is an input.
fn model() -> Result<(Model, Input), Failure> {
    let mut builder = ModelBuilder::new();
    let ground = builder.node("ground", [0.0; 3])?;
    builder.support(ground, &Dof::ALL);
    let joint = builder.attach("joint", ground, Revolute::new([0.0, 0.0, 1.0])?)?;
    let inertia = Matrix3::identity() * INERTIA;
    let body = RigidBody::new(1.0, inertia, Vector3::zeros())?;
    builder.element("body", body, &[joint.frame])?;
    let torque = builder.input(0.0);
    let motor = CoordinateForce::new(torque);
    builder.element("motor", motor, &[joint.coordinates[0]])?;
    Ok((builder.build()?, torque))
}

/// The controller: a torque from the angle and its rate, held until the next sample.
fn torque(angle: f64, rate: f64) -> f64 {
    -GAINS[0] * angle - GAINS[1] * rate
}

fn main() -> Result<(), Failure> {
    let (model, input) = model()?;
    let mut context = Context::new(model);
    let first = start(&context, 0.0, &[1.0], &[0.0])?;
    let options = DynamicOptions::new(H * SAMPLES as f64, H);

    // A step is a sample. While the torque is held, the motion is a parabola.
    let mut run = Simulation::new(&mut context, first, &options)?;
    let [mut angle, mut rate] = [1.0, 0.0];
    let mut snapshot = run.save();
    for sample in 0..SAMPLES {
        if sample == SAMPLES / 2 {
            snapshot = run.save();
        }
        let u = torque(run.state().q[0], run.state().v[0]);
        run.set_input(input, u);
        run.step()?;
        let acceleration = torque(angle, rate) / INERTIA;
        angle += H * rate + 0.5 * H * H * acceleration;
        rate += H * acceleration;
        assert!((run.state().q[0] - angle).abs() < 1e-12);
        assert!((run.state().v[0] - rate).abs() < 1e-12);
    }
    let end = run.state().clone();
    println!(
        "after {} s: {:.6} rad, {:.6} rad/s",
        end.t, end.q[0], end.v[0]
    );
    assert!(end.q[0].abs() < 1e-2);

    // The second half once more, from the snapshot: the same to the last bit.
    run.restore(&snapshot)?;
    for _ in SAMPLES / 2..SAMPLES {
        let u = torque(run.state().q[0], run.state().v[0]);
        run.set_input(input, u);
        run.step()?;
    }
    assert_eq!(run.state(), &end);

    // From 0.5 rad at rest the motor turns the joint back. It is switched off at 0 rad, and the run
    // ends at −1 rad.
    context.set_input(input, -5.0 * INERTIA);
    let first = start(&context, 0.0, &[0.5], &[0.0])?;
    let mut run = Simulation::new(&mut context, first, &options)?;
    run.add_event(
        |_, state| -state.q[0],
        move |context, _| {
            context.set_input(input, 0.0);
            Continue(())
        },
    );
    run.add_event(|_, state| -1.0 - state.q[0], |_, _| Break(()));
    let mut times = Vec::new();
    while let Some(step) = run.step()? {
        times.extend(step.events.iter().map(|_| step.progress.state.t));
    }
    for (time, exact) in times.iter().zip([0.2_f64.sqrt(), 0.8_f64.sqrt()]) {
        assert!((time - exact).abs() < 1e-12, "{times:?}");
    }
    assert_eq!(run.state().t, times[1]);
    Ok(())
}
