//! A joint from outside the library: a nut on a screw, in a model and in model files.

use pullback::Failure;
use pullback::check;
use pullback::input::Registry;
use pullback::prelude::*;
use std::error::Error;
use std::f64::consts::{FRAC_PI_2, TAU};

/// A nut on a screw: as it turns it moves along the axis.
#[derive(Clone, serde::Deserialize, schemars::JsonSchema)]
struct Screw {
    /// Axis, a unit vector of the reference configuration in global components.
    axis: [f64; 3],
    /// Displacement along the axis in one turn.
    pitch: f64,
}

impl Joint<1> for Screw {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 1>) -> Pose<S> {
        let (axis, angle) = (Vector3::from(self.axis), q[0]);
        let displacement = axis.map(S::constant) * (angle * (self.pitch / TAU));
        let turn = Quaternion::about(&axis, angle);
        Pose::identity().translated(&displacement).rotated(&turn)
    }

    fn coordinates(&self) -> [JointCoordinate; 1] {
        [("angle", Quantity::Angle)]
    }
}

const PITCH: f64 = 0.5;
const ARM: f64 = 0.8;
const MASS: f64 = 2.0;
const G: f64 = 9.81;
/// Angle at rest under the push, amplitude in motion.
const A: f64 = 1.2;

/// A nut with a weight on an arm runs on a horizontal screw and is pushed along it by a force that
/// grows with the load parameter.
fn context(push: f64) -> Result<Context, Box<dyn Error>> {
    let mut builder = ModelBuilder::new();
    let ground = builder.node("ground", [0.0; 3])?;
    builder.support(ground, &Dof::ALL);
    let screw = Screw {
        axis: [1.0, 0.0, 0.0],
        pitch: PITCH,
    };
    let nut = builder.attach("nut", ground, screw)?.frame;
    let bob = builder.offset("bob", nut, [0.0, 0.0, -ARM])?;
    let mass = PointMass::new(MASS)?;
    let weight = mass.weight([0.0, 0.0, -G], Constant(1.0));
    builder.element("mass", mass, &[bob])?;
    builder.element("weight", weight, &[bob])?;
    let push = NodalLoad::new(LoadKind::DeadForce, [push, 0.0, 0.0], Proportional(1.0));
    builder.element("push", push, &[nut])?;
    Ok(Context::new(builder.build()?))
}

/// The pushed nut stops where F p/2π = m g l sin φ.
fn at_rest() -> Result<(), Box<dyn Error>> {
    let moment = MASS * G * ARM;
    let mut context = context(moment * A.sin() * TAU / PITCH)?;
    let options = StaticOptions::equal_steps(1);
    let mut run = LoadSteps::new(&mut context, Vec::new(), &options)?;
    let mut residuals: Vec<f64> = Vec::new();
    while let Some(step) = run.step()? {
        residuals = step.residuals.iter().map(|i| i.residual[1]).collect();
    }
    let q = run.q();
    println!("at rest at {:.12}, residuals {residuals:?}", q[0]);
    assert!((q[0] - A).abs() < 1e-9);
    // Newton's method for M − m g l sin φ = 0 comes from below, where |r''| / 2 r'² is at most
    let constant = A.tan() / (2.0 * moment * A.cos());
    assert!(residuals.len() > 3);
    for pair in residuals.windows(2) {
        assert!(pair[1] <= constant * pair[0].powi(2) + 1e-14 * moment);
    }
    Ok(())
}

/// Time in which it falls from the amplitude to the lowest position, a quarter of the period of
/// (m l² + m p²/4π²) φ̈ = −m g l sin φ: a complete elliptic integral, by the arithmetic-geometric
/// mean.
fn quarter() -> f64 {
    let (mut a, mut b) = (1.0, (0.5 * A).cos());
    for _ in 0..6 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    let lead = PITCH / TAU;
    FRAC_PI_2 / a * ((ARM * ARM + lead * lead) / (G * ARM)).sqrt()
}

/// Half the step, a quarter of the error: the order of the scheme.
fn in_motion() -> Result<(), Box<dyn Error>> {
    let mut errors = Vec::new();
    for steps in [50, 100, 200] {
        let mut context = context(0.0)?;
        let state = start(&context, 0.0, &[A], &[0.0])?;
        let options = DynamicOptions::new(quarter(), quarter() / f64::from(steps));
        let mut run = Simulation::new(&mut context, state, &options)?;
        run.finish()?;
        errors.push(run.state().q[0].abs());
    }
    let orders = [errors[0] / errors[1], errors[1] / errors[2]].map(f64::log2);
    println!("in motion: {errors:?} from the lowest position, orders {orders:.3?}");
    assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.05));
    assert!(errors[2] < 1e-4);
    Ok(())
}

/// The joints of the library, and this one.
fn registry() -> Registry {
    Registry::standard().joint("screw", |at, keys: Screw| {
        let axis = Vector3::from(keys.axis).try_normalize(0.0);
        let axis = axis.ok_or("its axis has no direction")?.into();
        at.join(Screw { axis, ..keys })
    })
}

fn main() -> Result<(), Failure> {
    if std::env::args_os().len() > 1 {
        std::process::exit(pullback::cli::run(&registry(), std::env::args_os()).into());
    }
    let screw = Screw {
        axis: [0.36, 0.48, -0.8],
        pitch: 0.7,
    };
    check::joint(&screw).assert();
    at_rest()?;
    in_motion()?;
    Ok(())
}
