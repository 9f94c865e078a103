//! A constraint by its equation h(t, x) = 0: two sliders and the rod between them, three times.

use pullback::Failure;
use pullback::check;
use pullback::elements::constraint::{Multipliers, Penalty, PenaltyStiffness};
use pullback::elements::joint::Prismatic;
use pullback::integrators::dynamics::Progress;
use pullback::manifold::implicit::{Choice, Equations, Implicit, ImplicitMap};
use pullback::manifold::map::Linear;
use pullback::manifold::map::Map;
use pullback::manifold::system::Quantity;
use pullback::prelude::*;
use std::error::Error;
use std::f64::consts::FRAC_PI_2;

/// A rod of length L between a slider on the axis e1 and one on e2 (Archimedes' trammel). x has the
/// displacements of both from where they start.
#[derive(Clone, Copy)]
struct Trammel {
    start: [f64; 2],
}

impl Implicit<2, 1> for Trammel {
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, 2>) -> SVector<S, 1> {
        let [a, b] = [0, 1].map(|k| x[k] + self.start[k]);
        let h = a * a + b * b - LENGTH * LENGTH;
        SVector::<S, 1>::new(h * (0.5 / LENGTH))
    }

    fn coordinate(&self, k: usize) -> String {
        ["first displacement", "second displacement"][k].to_owned()
    }
}

const LENGTH: f64 = 0.8;
const MASS: f64 = 2.0;
const G: f64 = 9.81;
/// Angle of the rod to the vertical at the start: the first slider goes out to L and comes back.
const START: f64 = 2.0;

fn trammel() -> Trammel {
    let (sin, cos) = START.sin_cos();
    Trammel {
        start: [LENGTH * sin, -LENGTH * cos],
    }
}

/// Sliders with weight where they start, moved by the coordinates `x` of a node.
fn sliders(builder: &mut ModelBuilder, x: NodeId) -> Result<(), Box<dyn Error>> {
    let ground = builder.node("ground", [0.0; 3])?;
    builder.support(ground, &Dof::ALL);
    for (k, name) in ["first", "second"].into_iter().enumerate() {
        let (mut axis, mut position) = ([0.0; 3], [0.0; 3]);
        (axis[k], position[k]) = (1.0, trammel().start[k]);
        let pick = Linear::<2, 1>::pick(k, 0.0).boxed();
        let unknown = format!("{name} displacement");
        let displacement = builder.mapped_coordinates(unknown, &[Quantity::Length], pick, &[x])?;
        let start = builder.offset(format!("start of {name}"), ground, position)?;
        let joint = Prismatic::new(axis)?;
        let slider = builder.add_joint_frame(name, start, joint, &[displacement])?;
        let mass = PointMass::new(MASS)?;
        let weight = mass.weight([0.0, -G, 0.0], Constant(1.0));
        builder.element(format!("mass of {name}"), mass, &[slider])?;
        builder.element(format!("weight of {name}"), weight, &[slider])?;
    }
    Ok(())
}

/// How the rod is enforced.
#[derive(Clone, Copy, Debug)]
enum By {
    Map,
    Multipliers,
    Penalty(f64),
}

/// The model, and the node of x.
fn context(by: By) -> Result<(Context, NodeId), Box<dyn Error>> {
    let mut builder = ModelBuilder::new();
    let lengths = [Quantity::Length; 2];
    let x = match by {
        By::Map => {
            let map = ImplicitMap::of(trammel(), 1, 0.0, [0.0; 2], Choice::Split)?;
            let q = builder.coordinates("q", &[Quantity::Length])?;
            builder.mapped_coordinates("x", &lengths, Box::new(map), &[q])?
        }
        _ => builder.coordinates("x", &lengths)?,
    };
    sliders(&mut builder, x)?;
    let rod = Equations(trammel());
    match by {
        By::Map => {}
        By::Multipliers => {
            let force = builder.multipliers("force", 1)?;
            builder.element("rod", Multipliers::<_, 2, 1>::new(rod), &[x, force])?;
        }
        By::Penalty(p) => {
            let stiffness = PenaltyStiffness { p, tau: 1e-3 };
            builder.element("rod", Penalty::<_, 2, 1>::new(rod, stiffness)?, &[x])?;
        }
    }
    Ok((Context::new(builder.build()?), x))
}

/// Time until the rod hangs: with equal sliders it swings like a pendulum of its length, a complete
/// elliptic integral by the arithmetic-geometric mean.
fn quarter() -> f64 {
    let (mut a, mut b) = (1.0, (0.5 * START).cos());
    for _ in 0..6 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    FRAC_PI_2 / a * (LENGTH / G).sqrt()
}

/// Where the sliders are when it should hang, and what the run tells.
fn swung(by: By, steps: u32) -> Result<([f64; 2], Progress), Box<dyn Error>> {
    let (mut context, x) = context(by)?;
    let scheme = match by {
        By::Map => Scheme::newmark(0.25, 0.5)?,
        // Index 3, or a stiff spring: what cannot be resolved has to be damped.
        _ => Scheme::chung_hulbert(0.5)?,
    };
    let options = DynamicOptions {
        scheme,
        ..DynamicOptions::new(quarter(), quarter() / f64::from(steps))
    };
    let state = start(&context, 0.0, context.initial(), &[])?;
    let mut run = Simulation::new(&mut context, state, &options)?;
    run.finish()?;
    let progress = run.progress().clone();
    let moved = |k| context.coordinate(x, k).map_or(f64::NAN, |[x, ..]| x);
    Ok(([0, 1].map(|k| trammel().start[k] + moved(k)), progress))
}

/// The order of the scheme: half the step, a quarter of the error.
fn second_order(errors: [f64; 3]) {
    let orders = [errors[0] / errors[1], errors[1] / errors[2]].map(f64::log2);
    let off = errors.map(|e| format!("{e:.1e}")).join(", ");
    println!("  {off} from the axis, orders {orders:.3?}");
    assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.1));
}

fn main() -> Result<(), Failure> {
    let map = ImplicitMap::of(trammel(), 1, 0.0, [0.0; 2], Choice::Split)?;
    check::implicit(&map, 0.0).assert();
    check::element(&Multipliers::<_, 2, 1>::new(Equations(trammel()))).assert();

    // Tension of the rod as it hangs, m v²/L + m g.
    let tension = MASS * G * (3.0 - 2.0 * START.cos());
    let mut errors = [[0.0; 3]; 2];
    for (k, steps) in [200, 400, 800].into_iter().enumerate() {
        let (x, progress) = swung(By::Map, steps)?;
        errors[0][k] = x[0].abs();
        // The second displacement is the coordinate at the start, and cannot be in the end, where it is largest.
        assert!(progress.summary.chart_changes >= 1);
        assert!((x[0].hypot(x[1]) - LENGTH).abs() < 1e-14);
        let (x, progress) = swung(By::Multipliers, steps)?;
        errors[1][k] = x[0].abs();
        let force = progress.state.q[2];
        assert!(
            (force - tension).abs() < 1e-2 * tension,
            "{force} {tension}"
        );
    }
    println!("by the map:");
    second_order(errors[0]);
    println!("by multipliers:");
    second_order(errors[1]);

    // A penalty lets the rod grow by its tension over the stiffness.
    for p in [1e6, 2e6] {
        let ([_, y], _) = swung(By::Penalty(p), 800)?;
        let longer = -y - LENGTH;
        println!("by a penalty of {p:e}: longer by {longer:.3e}");
        assert!((longer - tension / p).abs() < 0.02 * tension / p);
    }
    Ok(())
}
