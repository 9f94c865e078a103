//! A planar four-bar linkage in closed form, and the equation of motion of its one freedom.

#![allow(non_snake_case, dead_code)]

use super::super::dynamics_support::*;
use super::{G, one_freedom};
use nalgebra::Vector2;
use pullback::manifold::jet::Taylor;
use pullback::manifold::scalar::Scalar;

/// Crank, coupler, rocker: where the crank points along the base the others are nearly parallel, so
/// that its angle hardly determines theirs.
pub const BARS: [f64; 3] = [1.0, 1.6, 1.5];
pub const BASE: f64 = 1.3;
pub const MASSES: [f64; 3] = [2.0, 1.0, 1.2];

/// Angles of coupler and rocker from that of the crank: the circles of their ends meet.
pub fn closed_form<S: Scalar>(crank: S) -> [S; 2] {
    let [a, b, c] = BARS;
    let (px, py) = (crank.cos() * a, crank.sin() * a);
    let (ux, uy) = (-px + BASE, -py);
    let r = (ux * ux + uy * uy).sqrt();
    let cosine = (r * r + (b * b - c * c)) / (r * (2.0 * b));
    let opening = (-(cosine * cosine) + 1.0).sqrt().atan2(cosine);
    let coupler = uy.atan2(ux) + opening;
    let (ex, ey) = (px + coupler.cos() * b, py + coupler.sin() * b);
    [coupler, ey.atan2(ex - BASE)]
}

pub const CRANK_START: f64 = 1.2;
pub const CRANK_RATE: f64 = 6.0;

pub fn four_bar_exact(to: f64) -> Vec<f64> {
    let ode = |_: f64, z: &Vector2<f64>| {
        let angle = Taylor {
            v: z[0],
            d: 1.0,
            dd: 0.0,
        };
        let [coupler, rocker] = closed_form(angle);
        let rate = |x: Taylor<f64>| Taylor {
            v: x.d,
            d: x.dd,
            dd: 0.0,
        };
        let (k2, k3) = (rate(coupler), rate(rocker));
        let ([a, b, c], [m1, m2, m3]) = (BARS, MASSES);
        let between = (angle - coupler).cos();
        let M = k2 * k2 * (m2 * b * b / 3.0)
            + k2 * between * (m2 * a * b)
            + k3 * k3 * (m3 * c * c / 3.0)
            + (m1 * a * a / 3.0 + m2 * a * a);
        let V = angle.sin() * ((0.5 * m1 + m2) * G * a)
            + coupler.sin() * (0.5 * m2 * G * b)
            + rocker.sin() * (0.5 * m3 * G * c);
        Vector2::new(z[1], one_freedom(M, V, z[1]))
    };
    let z = integrate_ode(&ode, Vector2::new(CRANK_START, CRANK_RATE), to, 40_000);
    assert!((z[0] - CRANK_START).abs() > std::f64::consts::TAU, "{z}");
    let angle = Taylor {
        v: z[0],
        d: z[1],
        dd: 0.0,
    };
    let [coupler, rocker] = closed_form(angle);
    vec![z[0], coupler.v, rocker.v, z[1], coupler.d, rocker.d]
}
