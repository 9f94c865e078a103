//! Critical loads of two rigid rods with springs in their joints: a dead load buckles them, a load that
//! follows the second rod makes them flutter.

use pullback::Failure;
use pullback::elements::joint::Revolute;
use pullback::elements::spring::{CoordinateLaw, CoordinateSpring};
use pullback::integrators::linearization::{buckling, stability_limit};
use pullback::integrators::statics::{
    ArcLengthOptions, CriticalKind, Event, PathSteps, StaticNewtonOptions, critical_point,
};
use pullback::manifold::system::Point;
use pullback::prelude::*;

/// Rods of length 1 along x with masses 2 and 1 at their ends, springs of stiffness 1 and equal dampers. The load
/// at the tip is the load parameter.
fn model(load: LoadKind, damping: f64) -> Result<Context, Failure> {
    let mut builder = ModelBuilder::new();
    let mut end = builder.node("ground", [0.0; 3])?;
    builder.support(end, &Dof::ALL);
    for (rod, x, mass) in [("first", 1.0, 2.0), ("second", 2.0, 1.0)] {
        let joint = builder.attach(
            &format!("{rod} joint"),
            end,
            Revolute::new([0.0, 0.0, 1.0])?,
        )?;
        let law = CoordinateLaw {
            k: 1.0,
            c: damping,
            ..CoordinateLaw::default()
        };
        let spring = CoordinateSpring::new(law)?;
        builder.element(format!("{rod} spring"), spring, &joint.coordinates)?;
        end = builder.offset(format!("{rod} end"), joint.frame, [x, 0.0, 0.0])?;
        builder.element(format!("{rod} mass"), PointMass::new(mass)?, &[end])?;
    }
    let push = NodalLoad::new(load, [-1.0, 0.0, 0.0], Proportional(1.0));
    builder.element("load", push, &[end])?;
    Ok(Context::new(builder.build()?))
}

fn close(what: &str, found: f64, exact: f64, tolerance: f64) {
    println!("{what}: {found:.10}, exact {exact:.10}");
    assert!((found / exact - 1.0).abs() < tolerance);
}

fn main() -> Result<(), Failure> {
    // A dead load P: the stiffness [1 − 2P, −P; −P, 1 − P] of the joint angles is singular at P = (3 − √5)/2.
    let critical = 0.5 * (3.0 - 5.0_f64.sqrt());
    let mut context = model(LoadKind::DeadForce, 0.0)?;
    let modes = buckling(&mut context, Point::statics(0.0, &[0.0; 2]), 2)?;
    close("linear buckling", modes[0].load, critical, 1e-10);

    let (near, shape) = (Point::statics(0.3, &[0.0; 2]), &modes[0].shape);
    let options = StaticNewtonOptions::default();
    let point = critical_point(&mut context, near, Some(shape), &options)?;
    close("critical point", point.t, critical, 1e-12);
    assert_eq!(point.kind, CriticalKind::Bifurcation);
    println!("after {} iterations", point.corrections.len());

    // The path, which leaves the straight rods there.
    let options = ArcLengthOptions {
        events: vec![(Event::Bifurcation, false), (Event::Load(0.5), true)],
        switch_branch: true,
        ..ArcLengthOptions::default()
    };
    let mut run = PathSteps::new(&mut context, Vec::new(), &options)?;
    while let Some(step) = run.step()? {
        println!("P = {:.6}: {:.6?}", step.t, step.q);
    }
    // Moments about both joints: k φ₂ = P sin(φ₁ + φ₂), k φ₁ = P (sin φ₁ + sin(φ₁ + φ₂)).
    let [first, second] = [0, 1].map(|k| run.q()[k]);
    let lever = (first + second).sin();
    close("P of the second spring", second / lever, 0.5, 1e-8);
    close(
        "P of the first spring",
        first / (first.sin() + lever),
        0.5,
        1e-8,
    );

    // A load along the second rod: flutter (Ziegler 1952). Small dampers
    // lower the load to 41/28 (Herrmann & Jong 1965).
    for (damping, exact, tolerance) in [
        (0.0, 3.5 - 2.0_f64.sqrt(), 1e-10),
        (1e-4, 41.0 / 28.0, 1e-6),
    ] {
        let mut context = model(LoadKind::FollowerForce, damping)?;
        let options = StaticOptions::default();
        let limit = stability_limit(&mut context, &[0.0; 2], [1.0, 3.0], 2, &options)?;
        close("flutter", limit.t, exact, tolerance);
        println!("at the frequency {:.6}", limit.mode.frequency());
        assert!(limit.mode.frequency() > 0.0);
    }
    Ok(())
}
