//! Exact motions of models of the gallery.

use crate::support::prelude::*;
use nalgebra::{Quaternion, Rotation3, UnitQuaternion};
use pullback::studies::compare::{FrameSample, Sample};
use pullback::studies::gallery::exact;

/// The nodes of a model at a time.
fn poses<const N: usize>(model: &str, nodes: [&str; N], t: f64) -> [FrameSample; N] {
    let names = nodes.map(str::to_owned);
    let mut sample = Sample::unknown(t, N);
    exact(model, &names).unwrap().fill(&mut sample);
    sample.nodes.try_into().unwrap()
}

/// The hinge and the bob.
fn pendulum(t: f64) -> [FrameSample; 2] {
    poses("pendulum", ["pivot", "rod"], t)
}

fn free_body(t: f64) -> FrameSample {
    let [body] = poses("free_body", ["O"], t);
    body
}

/// By central differences of the positions and rotations.
fn rates_follow(motion: impl Fn(f64) -> FrameSample, t: f64) {
    let h = 1e-4;
    let [before, now, after] = [t - h, t, t + h].map(motion);
    let turned = |a: &FrameSample, b: &FrameSample| {
        Rotation3::from_matrix_unchecked(b.R * a.R.transpose()).scaled_axis() / (2.0 * h)
    };
    let slope = |a: Vector3<f64>, b: Vector3<f64>| (b - a) / (2.0 * h);
    for (found, known) in [
        (turned(&before, &after), now.omega),
        (slope(before.omega, after.omega), now.omega_dot),
        (slope(before.position, after.position), now.velocity),
        (slope(before.velocity, after.velocity), now.acceleration),
    ] {
        assert!((found - known).norm() < 1e-5, "{t}: {found} {known}");
    }
}

#[test]
fn the_pendulum_swings_as_long_as_it_should() {
    // Period 4 K(k)/ω, K(sin 45°) = 1.85407467730137 (Abramowitz & Stegun, table 17.1).
    let gravity = 9.81_f64;
    let period = 4.0 * 1.854_074_677_301_37 / gravity.sqrt();
    for t in [0.0, 0.31, 0.97] {
        let [[_, a], [_, b]] = [t, t + 3.0 * period].map(pendulum);
        assert!((a.position - b.position).norm() < 1e-12);
        rates_follow(|t| pendulum(t)[0], t);
        rates_follow(|t| pendulum(t)[1], t);
        // At rest in the start.
        let energy = 0.5 * a.velocity.norm_squared() + gravity * a.position.z;
        assert!(energy.abs() < 1e-13);
    }
    let [_, lowest] = pendulum(0.25 * period);
    assert!((lowest.position + Vector3::z()).norm() < 1e-13);
    let [hinge, bob] = pendulum(0.7);
    assert!((hinge.R * Vector3::new(-1.0, 0.0, 0.0) - bob.position).norm() < 1e-14);
}

#[test]
fn the_free_body_is_where_it_should_be() {
    // R03: order-8 Runge-Kutta in extended precision, eight digits.
    let body = free_body(1.0);
    let rates = body.R.tr_mul(&body.omega);
    let known = Vector3::new(-8.74573438, 4.84996187, 5.05001221);
    assert!((rates - known).norm() < 2e-8, "{rates}");
    let known = Quaternion::new(0.24270299, 0.11814413, -0.82272015, -0.50026871);
    let known = UnitQuaternion::from_quaternion(known).to_rotation_matrix();
    assert!((body.R - known.matrix()).norm() < 4e-8, "{}", body.R);
    assert!((free_body(0.0).R - Matrix3::identity()).norm() < 1e-14);
    let inertia = Vector3::new(1.0, 2.0, 3.0);
    let L = inertia.component_mul(&Vector3::new(0.1, 10.0, 0.1));
    for t in [0.0, 1.3, 3.9, 8.0] {
        rates_follow(free_body, t);
        let FrameSample { R, omega, .. } = free_body(t);
        let kept = R * inertia.component_mul(&R.tr_mul(&omega));
        assert!((kept - L).norm() < 1e-12 * L.norm(), "{t}: {kept}");
    }
}
