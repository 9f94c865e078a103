//! Modes of a rotating blade: relative equilibrium, linearisation, frequencies.

use nalgebra::Matrix3;
use pullback::elements::joint::Revolute;
use pullback::elements::time::{Input, SteadyRotation};
use pullback::integrators::linearization::{ModeOptions, SteadyMotion, linearize, modes};
use pullback::manifold::system::Point;
use pullback::prelude::*;

/// A blade along x, clamped to a hub at its root, which rotates about z.
fn model() -> Result<(Model, Input), pullback::Failure> {
    let mut builder = ModelBuilder::new();
    let ground = builder.node("ground", [0.0; 3])?;
    builder.support(ground, &Dof::ALL);
    let hub = builder.attach("hub", ground, Revolute::new([0.0, 0.0, 1.0])?)?;
    let speed = builder.input(0.0);
    builder.prescribe_coordinate(hub.coordinates[0], 0, SteadyRotation(speed));

    // Slender: almost no stretching, shear and rotary inertia.
    let section = Section::diagonal(1e8, [2e7; 2], 1e4, [1.0, 1.0])?
        .with_mass(1.0, Matrix3::from_diagonal(&[2e-9, 1e-9, 1e-9].into()))?;
    // The coordinates of the blade are relative to the hub.
    let line = BeamLine {
        order: 3,
        relative_to: Some(hub.frame),
        ..BeamLine::new(8, section)
    };
    let root = builder.offset("root", hub.frame, [0.0; 3])?;
    let tip = builder.relative_node("tip", hub.frame, [1.0, 0.0, 0.0])?;
    let axis = StraightLine::new(builder.position(root), builder.position(tip.frame));
    builder.line("blade", &axis, [root, tip.frame], &line)?;
    Ok((builder.build()?, speed))
}

fn main() -> Result<(), pullback::Failure> {
    let (model, speed) = model()?;
    let mut context = Context::new(model);
    // Wright, Smith, Thresher & Wang 1982: flap μ in units of √(EI/m)/L², lag √(μ² − Ω²).
    for (omega, flap) in [(2.0, 4.13731957303), (6.0, 7.360373019310019)] {
        let options = StaticOptions {
            to: omega,
            ..StaticOptions::default()
        };
        let q = equilibrium(&mut SteadyMotion::new(&mut context, 0.0, speed), &options)?;
        context.set_input(speed, omega);
        let zeros = vec![0.0; q.len()];
        let at = Point {
            t: 0.0,
            q: &q,
            v: &zeros,
            a: &zeros,
        };
        let found = modes(&linearize(&mut context, at)?, &ModeOptions::lowest(2))?;
        let [lag_found, flap_found] = [0, 1].map(|k| found.modes[k].omega());
        println!("Ω = {omega}: lag {lag_found:.6}, flap {flap_found:.6}");
        let lag = f64::sqrt(flap * flap - omega * omega);
        for (found, exact) in [(flap_found, flap), (lag_found, lag)] {
            assert!((found / exact - 1.0).abs() < 1e-6, "{found} for {exact}");
        }
    }
    Ok(())
}
