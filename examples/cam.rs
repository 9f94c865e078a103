//! A cam with a roller follower: the roller's centre stands off the cam along its normal, which is the
//! derivative of the contour.

use nalgebra::Matrix3;
use pullback::Failure;
use pullback::check;
use pullback::elements::joint::{Curve, OnCurve, Prismatic, Revolute};
use pullback::elements::spring::{CoordinateLaw, CoordinateSpring};
use pullback::manifold::jet::Grad;
use pullback::prelude::*;
use std::error::Error;
use std::f64::consts::TAU;

/// A disc of radius R that turns about a point at a distance e from its centre, and a roller of
/// radius ρ that it carries on its rim.
#[derive(Clone)]
struct Cam;

impl Cam {
    /// The contour. Its parameter is no angle and no length: the derivative has no unit length either.
    fn contour<S: Scalar>(&self, s: S) -> [S; 2] {
        let u = s + s.sin() * 0.3;
        [u.sin() * RADIUS, u.cos() * RADIUS + ECCENTRICITY]
    }
}

impl Curve for Cam {
    /// The roller's centre c + ρ n.
    fn at<S: Scalar>(&self, s: S) -> Vector3<S> {
        let [x, y] = self.contour(Grad::<S, 1>::variable(s, 0));
        let (dx, dy) = (x.g[0], y.g[0]);
        let off = (dx * dx + dy * dy).sqrt().recip() * ROLLER;
        Vector3::new(x.v - dy * off, y.v + dx * off, S::zero())
    }
}

const RADIUS: f64 = 0.5;
const ECCENTRICITY: f64 = 0.2;
const ROLLER: f64 = 0.15;
/// Inertia of the cam about its axis, mass of the follower.
const INERTIA: f64 = 0.3;
const MASS: f64 = 2.0;
/// The spring that holds the follower on the cam, and its compression at the start.
const STIFFNESS: f64 = 400.0;
const SQUEEZED: f64 = 0.4;
/// How fast the cam turns at the start, with the follower at its highest.
const SPEED: f64 = 12.0;

/// Height of the follower and its derivative by the angle of the cam: that of the slider of a crank e
/// with a rod R + ρ.
fn lift(phi: f64) -> [f64; 2] {
    let (s, c) = phi.sin_cos();
    let rod = ((RADIUS + ROLLER).powi(2) - (ECCENTRICITY * s).powi(2)).sqrt();
    let slope = -ECCENTRICITY * s - ECCENTRICITY * ECCENTRICITY * s * c / rod;
    [ECCENTRICITY * c + rod, slope]
}

/// The model, the angle of the cam and the displacement of the follower.
fn context() -> Result<(Context, [NodeId; 2]), Box<dyn Error>> {
    let mut builder = ModelBuilder::new();
    let ground = builder.node("ground", [0.0; 3])?;
    builder.support(ground, &Dof::ALL);
    let cam = builder.attach("cam", ground, Revolute::new([0.0, 0.0, 1.0])?)?;
    let disc = RigidBody::new(1.0, Matrix3::identity() * INERTIA, Vector3::zeros())?;
    builder.element("disc", disc, &[cam.frame])?;
    let roller = builder.attach_free("roller", cam.frame, OnCurve::new(Cam))?;

    let guide = builder.offset("guide", ground, [0.0, lift(0.0)[0], 0.0])?;
    let follower = builder.attach("follower", guide, Prismatic::new([0.0, 1.0, 0.0])?)?;
    builder.element("mass", PointMass::new(MASS)?, &[follower.frame])?;
    let law = CoordinateLaw {
        k: STIFFNESS,
        x0: -SQUEEZED,
        ..CoordinateLaw::default()
    };
    builder.element("spring", CoordinateSpring::new(law)?, &follower.coordinates)?;

    builder.prefer(cam.coordinates[0]);
    builder.close(roller.frame, follower.frame)?;
    Ok((
        Context::new(builder.build()?),
        [cam.coordinates[0], follower.coordinates[0]],
    ))
}

/// Time until the cam has turned by an angle: energy tells how fast it turns,
/// (J + m y'^2) w^2 + k (y - y0)^2 = constant, and Simpson's rule sums up 1/w.
fn time(angle: f64) -> f64 {
    let squeezed = |phi: f64| SQUEEZED + lift(phi)[0] - lift(0.0)[0];
    let energy = INERTIA * SPEED * SPEED + STIFFNESS * SQUEEZED * SQUEEZED;
    let inverse = |phi: f64| {
        let inertia = INERTIA + MASS * lift(phi)[1].powi(2);
        (inertia / (energy - STIFFNESS * squeezed(phi).powi(2))).sqrt()
    };
    let count = 10_000;
    let h = angle / f64::from(count);
    let weight = |k: i32| match k {
        0 => 1.0,
        _ if k == count => 1.0,
        _ if k % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let sum: f64 = (0..=count)
        .map(|k| weight(k) * inverse(f64::from(k) * h))
        .sum();
    sum * h / 3.0
}

fn main() -> Result<(), Failure> {
    check::joint(&OnCurve::new(Cam)).assert();
    let mut errors = Vec::new();
    for steps in [200, 400, 800] {
        let (mut context, [angle, displacement]) = context()?;
        let state = start(&context, 0.0, &[0.0], &[SPEED])?;
        let options = DynamicOptions::new(1.0, 1.0 / f64::from(steps));
        let mut run = Simulation::new(&mut context, state, &options)?;
        while run.step()?.is_some() {
            // The follower is as high as the slider of a crank, and rises as fast.
            let coordinate = |node| run.system().coordinate(node, 0).unwrap_or_default();
            let ([phi, omega, _], [x, rate, _]) = (coordinate(angle), coordinate(displacement));
            let [height, slope] = lift(phi);
            assert!((x - (height - lift(0.0)[0])).abs() < 1e-12);
            assert!((rate - slope * omega).abs() < 1e-11);
        }
        let turned = run.state().q[0];
        println!("{steps} steps: turned by {turned:.6}");
        assert!(turned > TAU);
        errors.push((time(turned) - 1.0).abs());
    }
    println!("errors in time {errors:?}");
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 2.0).abs() < 0.1, "order {order}");
    }
    Ok(())
}
