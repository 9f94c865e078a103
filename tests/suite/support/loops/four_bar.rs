//! A planar four-bar linkage in closed form, and the equation of motion of its one freedom.

use super::{G, one_freedom, slope};
use crate::support::dynamics::*;
use crate::support::prelude::*;

/// Lengths of crank, coupler, rocker and base, the last from the origin along e1: where the crank points along it
/// coupler and rocker are nearly parallel, so that its angle hardly determines theirs.
pub const BARS: [f64; 4] = [1.0, 1.6, 1.5, 1.3];
/// Those of examples/models/four_bar.toml, where the crank is drawn along e2.
pub const DRAWN: [f64; 4] = [1.0, 1.5, 1.941_648_783_894_759_8, 1.6];
pub const MASSES: [f64; 3] = [2.0, 1.0, 1.2];

/// Angles of coupler and rocker from that of the crank: the circles of their ends meet.
pub fn closed_form<S: Scalar>([a, b, c, base]: [f64; 4], crank: S) -> [S; 2] {
    let (px, py) = (crank.cos() * a, crank.sin() * a);
    let (ux, uy) = (-px + base, -py);
    let r = (ux * ux + uy * uy).sqrt();
    let cosine = (r * r + (b * b - c * c)) / (r * (2.0 * b));
    let opening = (-(cosine * cosine) + 1.0).sqrt().atan2(cosine);
    let coupler = uy.atan2(ux) + opening;
    let (ex, ey) = (px + coupler.cos() * b, py + coupler.sin() * b);
    [coupler, ey.atan2(ex - base)]
}

pub const CRANK_START: f64 = 1.2;
pub const CRANK_RATE: f64 = 6.0;

/// Angles of all bars by that of the crank, with their derivatives by it.
pub fn by_crank(angle: f64) -> [Moving<0>; 3] {
    let angle = Moving::<0>::given([angle, 1.0, 0.0]);
    let [coupler, rocker] = closed_form(BARS, angle);
    [angle, coupler, rocker]
}

/// The mass M (kinetic energy ½ M θ̇²) by the angle of the crank, and the potential of the weights of uniform bars.
pub fn mass_and_potential(
    [a, b, c, _]: [f64; 4],
    [angle, coupler, rocker]: [Moving<0>; 3],
) -> [Moving<0>; 2] {
    let [m1, m2, m3] = MASSES;
    let (k2, k3) = (slope(coupler), slope(rocker));
    let M = k2 * k2 * (m2 * b * b / 3.0)
        + k2 * (angle - coupler).cos() * (m2 * a * b)
        + k3 * k3 * (m3 * c * c / 3.0)
        + (m1 / 3.0 + m2) * a * a;
    let V = angle.sin() * ((0.5 * m1 + m2) * G * a)
        + coupler.sin() * (0.5 * m2 * G * b)
        + rocker.sin() * (0.5 * m3 * G * c);
    [M, V]
}

/// Angular acceleration of the crank.
fn crank_acceleration(angle: f64, rate: f64) -> f64 {
    let [M, V] = mass_and_potential(BARS, by_crank(angle));
    one_freedom(M, V, rate)
}

pub fn four_bar_exact(to: f64) -> Vec<f64> {
    let ode = |_: f64, z: &Vector2<f64>| Vector2::new(z[1], crank_acceleration(z[0], z[1]));
    let z = integrate_ode(&ode, Vector2::new(CRANK_START, CRANK_RATE), to, 40_000);
    assert!((z[0] - CRANK_START).abs() > std::f64::consts::TAU, "{z}");
    let [angle, coupler, rocker] = by_crank(z[0]);
    let rate = |x: Moving<0>| x.x[1] * z[1];
    vec![
        z[0],
        coupler.x[0],
        rocker.x[0],
        rate(angle),
        rate(coupler),
        rate(rocker),
    ]
}

/// Force of the coupler on the rocker in the pin between them, by Newton's and Euler's laws for
/// these two bars.
pub fn pin_force(angle: f64, rate: f64) -> Vector2<f64> {
    let q_ddot = crank_acceleration(angle, rate);
    // Angle, its rate and acceleration of each bar.
    let [crank, coupler, rocker] = by_crank(angle).map(|x| {
        let [x, d, dd] = x.x;
        [x, d * rate, dd * rate * rate + d * q_ddot]
    });
    let along = |x: [f64; 3], l: f64| Vector2::new(x[0].cos(), x[0].sin()) * l;
    let acceleration = |x: [f64; 3], l: f64| {
        let r = along(x, l);
        Vector2::new(-r.y, r.x) * x[2] - r * (x[1] * x[1])
    };
    let ([a, b, c, _], [_, m2, m3]) = (BARS, MASSES);
    let weight = |m: f64| Vector2::new(0.0, -G * m);
    let half = along(coupler, 0.5 * b);
    let m2_a2 = (acceleration(crank, a) + acceleration(coupler, 0.5 * b)) * m2;
    // Rocker about its foot: r × F = J θ̈ − (r/2) × weight. Coupler about its centre, with
    // m a − weight + F at its first end and −F at the other: −2 (half × F) = I θ̈ + half × (m a − weight).
    let r = along(rocker, c);
    let first = m3 * c * c / 3.0 * rocker[2] - (r * 0.5).perp(&weight(m3));
    let second = m2 * b * b / 12.0 * coupler[2] + half.perp(&(m2_a2 - weight(m2)));
    let A = nalgebra::Matrix2::new(-r.y, r.x, 2.0 * half.y, -2.0 * half.x);
    A.lu().solve(&Vector2::new(first, second)).unwrap()
}
