//! A joint from outside the library: a point on a space curve, on which every swing takes the same
//! time.

use pullback::Failure;
use pullback::check;
use pullback::elements::joint::JointNodes;
use pullback::elements::load::CoordinateForce;
use pullback::prelude::*;
use std::error::Error;
use std::f64::consts::PI;

/// A point on a cycloid that is wound around an upright cylinder; it does not turn.
#[derive(Clone)]
struct Wound {
    /// Radius of the wheel that draws the cycloid: the lowest position has the parameter 0.
    wheel: f64,
    /// Radius of the cylinder.
    cylinder: f64,
}

impl Joint<1> for Wound {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 1>) -> Pose<S> {
        let (s, p) = (q[0], self.wheel / self.cylinder);
        let (around, up) = ((s + s.sin()) * p, (-s.cos() + 1.0) * p);
        let seen = Vector3::new(around.cos() - 1.0, around.sin(), up).map(|x| x * self.cylinder);
        Pose::identity().translated(&seen)
    }

    fn coordinates(&self) -> [JointCoordinate; 1] {
        [("parameter", Quantity::Other)]
    }
}

const WHEEL: f64 = 0.4;
const MASS: f64 = 1.5;
const G: f64 = 9.81;

/// A bead on the curve, with weight and a force on the parameter that grows with the load parameter.
fn context(force: f64) -> Result<Context, Box<dyn Error>> {
    let mut builder = ModelBuilder::new();
    let ground = builder.node("ground", [0.0; 3])?;
    builder.support(ground, &Dof::ALL);
    let curve = Wound {
        wheel: WHEEL,
        cylinder: 0.3,
    };
    let JointNodes { frame, coordinates } = builder.attach("bead", ground, curve)?;
    let mass = PointMass::new(MASS)?;
    let weight = mass.weight([0.0, 0.0, -G], Constant(1.0));
    builder.element("mass", mass, &[frame])?;
    builder.element("weight", weight, &[frame])?;
    let force = CoordinateForce::new(Proportional(force));
    builder.element("force", force, &coordinates)?;
    Ok(Context::new(builder.build()?))
}

/// The bead stops where F = m g a sin s.
fn at_rest() -> Result<(), Box<dyn Error>> {
    let (s, weight) = (1.2_f64, MASS * G * WHEEL);
    let mut context = context(weight * s.sin())?;
    let options = StaticOptions::equal_steps(1);
    let mut run = LoadSteps::new(&mut context, Vec::new(), &options)?;
    let mut residuals: Vec<f64> = Vec::new();
    while let Some(step) = run.step()? {
        residuals = step.residuals.iter().map(|i| i.residual[2]).collect();
    }
    let q = run.q();
    println!("at rest at {:.12}, residuals {residuals:?}", q[0]);
    assert!((q[0] - s).abs() < 1e-9);
    // Newton's method for F − m g a sin s = 0 comes from below, where |r''| / 2 r'² is at most
    let constant = s.tan() / (2.0 * weight * s.cos());
    assert!(residuals.len() > 3);
    for pair in residuals.windows(2) {
        assert!(pair[1] <= constant * pair[0].powi(2) + 1e-14 * weight);
    }
    Ok(())
}

/// The cycloid is Huygens' tautochrone, also when it is wound: the way along it from the lowest
/// position, 4 a sin(s/2), swings with ω = ½ √(g/a) from any height.
fn in_motion() -> Result<(), Box<dyn Error>> {
    let quarter = PI * (WHEEL / G).sqrt();
    for amplitude in [0.3, 1.5, 2.8] {
        let mut errors = Vec::new();
        for steps in [50, 100, 200] {
            let mut context = context(0.0)?;
            let state = start(&context, 0.0, &[amplitude], &[0.0])?;
            let options = DynamicOptions::new(quarter, quarter / f64::from(steps));
            let mut run = Simulation::new(&mut context, state, &options)?;
            run.finish()?;
            errors.push(run.state().q[0].abs());
        }
        println!("from {amplitude}: {errors:?} from the lowest position");
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((order - 2.0).abs() < 0.1, "order {order}");
        }
        assert!(errors[2] < 1e-3 * amplitude);
    }
    Ok(())
}

fn main() -> Result<(), Failure> {
    let curve = Wound {
        wheel: 0.3,
        cylinder: 0.5,
    };
    check::joint(&curve).assert();
    at_rest()?;
    in_motion()?;
    Ok(())
}
