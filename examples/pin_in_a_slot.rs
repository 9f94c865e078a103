//! A joint from outside the library: a pin in a slot, which carries a pendulum.

use pullback::Failure;
use pullback::check;
use pullback::elements::joint::JointNodes;
use pullback::elements::load::CoordinateForce;
use pullback::elements::spring::{CoordinateLaw, CoordinateSpring};
use pullback::prelude::*;
use std::error::Error;

/// A pin that slides along a slot of its parent, up to its ends, and turns in it.
#[derive(Clone)]
struct Slot {
    /// Along the slot: a unit vector of the reference configuration, global components.
    along: Vector3<f64>,
    /// Along the pin, likewise.
    pin: Vector3<f64>,
    /// Distance from the middle to either end.
    end: f64,
}

impl Joint<2> for Slot {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 2>) -> Pose<S> {
        Pose::identity()
            .translated(&(self.along.map(S::constant) * q[0]))
            .rotated(&Quaternion::about(&self.pin, q[1]))
    }

    fn coordinates(&self) -> [JointCoordinate; 2] {
        [("along", Quantity::Length), ("angle", Quantity::Angle)]
    }

    fn domain(&self, _t: f64, q: &SVector<f64, 2>) -> Result<f64, DomainError> {
        let margin = self.end - q[0].abs();
        DomainError::within(margin, "its slot at an end: make it longer, or stop before")
    }
}

const LENGTH: f64 = 0.6;
const PIN: f64 = 1.0;
const BOB: f64 = 0.8;
const G: f64 = 9.81;
const SPRING: f64 = 30.0;

/// A pendulum swings from a pin in a horizontal slot. A spring may hold the pin, a force pulls it
/// and a moment turns it, the latter two in proportion to the load parameter.
fn context(spring: f64, pull: f64, moment: f64, end: f64) -> Result<Context, Box<dyn Error>> {
    let mut builder = ModelBuilder::new();
    let ground = builder.node("ground", [0.0; 3])?;
    builder.support(ground, &Dof::ALL);
    let slot = Slot {
        along: Vector3::x(),
        pin: -Vector3::y(),
        end,
    };
    let JointNodes { frame, coordinates } = builder.attach("pin", ground, slot)?;
    let [displacement, angle] = coordinates[..] else {
        return Err("the slot has a displacement and an angle".into());
    };
    let bob = builder.offset("bob", frame, [0.0, 0.0, -LENGTH])?;
    let mass = PointMass::new(BOB)?;
    let weight = mass.weight([0.0, 0.0, -G], Constant(1.0));
    builder.element("pin mass", PointMass::new(PIN)?, &[frame])?;
    builder.element("mass", mass, &[bob])?;
    builder.element("weight", weight, &[bob])?;
    if spring > 0.0 {
        let law = CoordinateLaw {
            k: spring,
            ..CoordinateLaw::default()
        };
        builder.element("spring", CoordinateSpring::new(law)?, &[displacement])?;
    }
    builder.element(
        "pull",
        CoordinateForce::new(Proportional(pull)),
        &[displacement],
    )?;
    builder.element(
        "moment",
        CoordinateForce::new(Proportional(moment)),
        &[angle],
    )?;
    Ok(Context::new(builder.build()?))
}

/// Way and angle at rest follow from k u = F and m g l sin φ = M.
fn at_rest() -> Result<(), Box<dyn Error>> {
    let (u, phi, weight) = (0.25, 1.1_f64, BOB * G * LENGTH);
    let mut context = context(SPRING, SPRING * u, weight * phi.sin(), 0.5)?;
    let options = StaticOptions::equal_steps(1);
    let mut run = LoadSteps::new(&mut context, Vec::new(), &options)?;
    let mut residuals: Vec<f64> = Vec::new();
    while let Some(step) = run.step()? {
        residuals = step.residuals.iter().map(|i| i.residual[1]).collect();
    }
    let q = run.q();
    println!("at rest at {q:.12?}, residuals {residuals:?}");
    assert!((q[0] - u).abs() < 1e-9 && (q[1] - phi).abs() < 1e-9);
    // Newton's method for M − m g l sin φ = 0 comes from below, where |r''| / 2 r'² is at most
    let constant = phi.tan() / (2.0 * weight * phi.cos());
    assert!(residuals.len() > 3);
    for pair in residuals.windows(2) {
        assert!(pair[1] <= constant * pair[0].powi(2) + 1e-14 * weight);
    }
    Ok(())
}

/// Without a spring nothing acts along the slot: the centre of mass stays, and energy tells how fast
/// the pendulum is. Both are met with the order of the scheme.
fn in_motion() -> Result<(), Box<dyn Error>> {
    let (first, share) = (1.3_f64, BOB / (PIN + BOB));
    let mut errors = Vec::new();
    for steps in [50, 100, 200] {
        let mut context = context(0.0, 0.0, 0.0, 0.5)?;
        let state = start(&context, 0.0, &[0.0, first], &[0.0; 2])?;
        let options = DynamicOptions::new(0.3, 0.3 / f64::from(steps));
        let mut run = Simulation::new(&mut context, state, &options)?;
        run.finish()?;
        let (q, v) = (&run.state().q, &run.state().v);
        let (s, c) = q[1].sin_cos();
        let displacement = share * LENGTH * (first.sin() - s);
        // ½ m l² φ̇² (1 − m cos² φ / (M + m)) = m g l (cos φ − cos φ₀).
        let rate = -(2.0 * G / LENGTH * (c - first.cos()) / (1.0 - share * c * c)).sqrt();
        errors.push([(q[0] - displacement).abs(), (v[1] - rate).abs()]);
    }
    println!("in motion: errors of displacement and rate {errors:?}");
    for k in 0..2 {
        for pair in errors.windows(2) {
            let order = (pair[0][k] / pair[1][k]).log2();
            assert!((order - 2.0).abs() < 0.1, "order {order}");
        }
        assert!(errors[2][k] < 1e-4);
    }
    Ok(())
}

/// In a short slot the motion ends at the end, with the name of the joint.
fn at_the_end() -> Result<(), Box<dyn Error>> {
    let mut context = context(0.0, 0.0, 0.0, 0.1)?;
    let state = start(&context, 0.0, &[0.0, 1.3], &[0.0; 2])?;
    let mut run = Simulation::new(&mut context, state, &DynamicOptions::new(1.0, 0.005))?;
    let error = run
        .finish()
        .err()
        .ok_or("the pin left its slot")?
        .to_string();
    println!("at the end: {error}");
    assert!(error.contains("pin") && error.contains("its slot at an end"));
    // The pin has stopped within the displacement of a step from the end.
    let u = run.state().q[0];
    assert!(u <= 0.1 && u > 0.09, "{u}");
    Ok(())
}

fn main() -> Result<(), Failure> {
    let slot = Slot {
        along: Vector3::new(0.6, 0.0, 0.8),
        pin: Vector3::new(-0.8, 0.0, 0.6),
        end: f64::INFINITY,
    };
    check::joint(&slot).assert();
    at_rest()?;
    in_motion()?;
    at_the_end()?;
    Ok(())
}
