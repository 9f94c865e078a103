//! An element by its energy: a hardening spring, at rest and swinging.

use pullback::Failure;
use pullback::check;
use pullback::elements::energy::EnergyElement;
use pullback::manifold::scalar::Scalar;
use pullback::prelude::*;

/// A spring between two frame nodes with the energy ½ k e² + ¼ k₃ e⁴ in its elongation e.
struct HardeningSpring {
    k: f64,
    k3: f64,
    /// From the first node to the second where there is no force.
    apart: Vector3<f64>,
}

impl EnergyElement<12> for HardeningSpring {
    fn potential<S: Scalar>(&self, _t: S, x: &SVector<S, 12>) -> S {
        let u = Vector3::from_fn(|i, _| x[6 + i] - x[i] + self.apart[i]);
        let e = u.dot(&u).sqrt() - self.apart.norm();
        e * e * (e * e * (0.25 * self.k3) + 0.5 * self.k)
    }
}

const K: f64 = 40.0;
const K3: f64 = 1000.0;
const MASS: f64 = 2.0;
/// Elongation in statics, amplitude in motion.
const E: f64 = 0.3;

/// A mass on a rail, held by the spring and pulled by a force that grows with time.
fn context(force: f64) -> Result<Context, Box<dyn std::error::Error>> {
    let mut builder = ModelBuilder::new();
    let wall = builder.node("wall", [0.0; 3])?;
    let slider = builder.node("slider", [1.5, 0.0, 0.0])?;
    builder.support(wall, &Dof::ALL);
    builder.support(slider, &[Dof::Y, Dof::Z, Dof::RX, Dof::RY, Dof::RZ]);
    let spring = HardeningSpring {
        k: K,
        k3: K3,
        apart: Vector3::new(1.5, 0.0, 0.0),
    };
    builder.element("spring", spring.into_element(), &[wall, slider])?;
    builder.element("mass", PointMass::new(MASS)?, &[slider])?;
    let pull = NodalLoad::new(LoadKind::DeadForce, [force, 0.0, 0.0], Proportional(1.0));
    builder.element("pull", pull, &[slider])?;
    Ok(Context::new(builder.build()?))
}

/// The period of m ẍ + k x + k₃ x³ = 0 at the amplitude A: 4 K(m)/ω with ω² = (k + k₃A²)/m and the
/// parameter k₃A²/(2k + 2k₃A²), the complete elliptic integral by the arithmetic-geometric mean.
fn period() -> f64 {
    let stiffness = K + K3 * E * E;
    let parameter = 0.5 * K3 * E * E / stiffness;
    let (mut a, mut b) = (1.0, (1.0 - parameter).sqrt());
    for _ in 0..6 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    std::f64::consts::TAU / a / (stiffness / MASS).sqrt()
}

fn main() -> Result<(), Failure> {
    let spring = HardeningSpring {
        k: K,
        k3: K3,
        apart: Vector3::new(0.9, -0.5, 0.4),
    };
    check::element(&spring.into_element()).assert();

    // At rest: k e + k₃ e³ is the force.
    let mut context = context(K * E + K3 * E.powi(3))?;
    let mut run = LoadSteps::new(&mut context, Vec::new(), &StaticOptions::default())?;
    while let Some(step) = run.step()? {
        println!("{:.3}: {} iterations", step.t, step.iterations);
    }
    let elongation = run.q()[0];
    println!("elongation {elongation:.12}");
    assert!((elongation - E).abs() < 1e-9);

    // Released at the amplitude, it is in the middle after a quarter of the period. The error of
    // the scheme is of second order: half the step, a quarter of it.
    let quarter = 0.25 * period();
    let mut errors = Vec::new();
    for steps in [50, 100, 200] {
        let mut context = self::context(0.0)?;
        let state = start(&context, 0.0, &[E], &[0.0])?;
        let options = DynamicOptions::new(quarter, quarter / f64::from(steps));
        let mut run = Simulation::new(&mut context, state, &options)?;
        run.finish()?;
        let x = run.state().q[0];
        println!("{steps} steps: {x:.3e} from the middle");
        errors.push(x.abs());
    }
    let orders = [errors[0] / errors[1], errors[1] / errors[2]].map(f64::log2);
    println!("orders {orders:.3?}");
    assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.05));
    assert!(errors[2] < 1e-4 * E);
    Ok(())
}
