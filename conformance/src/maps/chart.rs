//! The laws of a chart of rotations: coordinates and quaternions determine each other, and a change of
//! coordinates keeps the motion.

use super::map::{TIME, laws, short_name};
use crate::report::Report;
use crate::sample::{CLEARANCE, Random};
use nalgebra::{SVector, Vector3};
use pullback_manifold::chart::{Charted, RotationChart};
use pullback_manifold::map::{Map, Reparametrization};
use pullback_manifold::so3;
use std::f64::consts::TAU;

/// Coordinates are recovered to this fraction of their size.
///
/// A logarithm loses at most the inverse of the distance 0.3 to the edge of its chart; some ten
/// operations of 1e-16 each remain below 1e-14.
const RECOVERED: f64 = 1e-12;

/// Checks every law of a chart, and of the map [`Charted`] from its coordinates to the rotation vector,
/// at every position inside both.
pub fn chart<C: RotationChart>(chart: &C) -> Report {
    let mut report = Report::new(short_name::<C>());
    let mut random = Random::default();
    let mut evaluated = 0;
    for (at, q) in random.positions(3) {
        let q = Vector3::from_column_slice(&q);
        let margin = chart.margin(&q);
        if margin.is_nan() || margin <= CLEARANCE {
            continue;
        }
        let turn = chart.quaternion(&q);
        if TAU - so3::log_quaternion(&turn).norm() <= CLEARANCE {
            continue;
        }
        evaluated += 1;
        let allowed = RECOVERED * (1.0 + q.norm());
        let unit = (turn.dot(&turn) - 1.0).abs();
        report.defect("the quaternion is a unit", at, unit, RECOVERED);
        let gap = (chart.coordinates(&turn) - q).norm();
        report.defect("coordinates(quaternion(c)) = c", at, gap, allowed);
        let mut map = Charted::<C, 3>::new(*chart);
        let v = random.of_norm(1.0);
        let a = random.of_norm(1.0);
        let psi = so3::log_quaternion(&turn);
        change(
            &mut report,
            "rotation vector to chart",
            at,
            &mut map,
            [psi, v, a],
        );
        laws(&mut report, &map, at, &q, &mut random);
        if turn.w >= 0.0 {
            continue;
        }
        let opposite = chart.coordinates(&turn.opposite());
        let found = chart.quaternion(&opposite);
        let gap = (found.v + turn.v).norm() + (found.w + turn.w).abs();
        report.defect("the opposite has coordinates of its own", at, gap, allowed);
        change(&mut report, "chart to opposite", at, &mut map, [q, v, a]);
    }
    if evaluated == 0 {
        report.impossible("domain", "everywhere", "no position is inside the chart");
    }
    report
}

/// Checks that a change of coordinates keeps rotation, angular velocity and angular acceleration.
fn change<C: RotationChart>(
    report: &mut Report,
    law: &'static str,
    at: &str,
    map: &mut Charted<C, 3>,
    [q, v, a]: [Vector3<f64>; 3],
) {
    let before = spin(map, [q, v, a]);
    let (mut q, mut v, mut seconds) = (q, v, [a.as_slice().to_vec()]);
    map.reparametrize(TIME, q.as_mut_slice(), v.as_mut_slice(), &mut seconds);
    let a = Vector3::from_column_slice(&seconds[0]);
    let after = spin(map, [q, v, a]);
    let size = 1.0 + before.iter().fold(0.0, |m: f64, x| m.max(x.norm()));
    let gap = (before.iter().zip(&after)).fold(0.0, |m: f64, (b, a)| m.max((b - a).norm()));
    report.defect(law, at, gap, RECOVERED * size * size);
}

/// Two rotated vectors, the angular velocity and the angular acceleration (global components).
fn spin<C: RotationChart>(map: &Charted<C, 3>, [q, v, a]: [Vector3<f64>; 3]) -> [Vector3<f64>; 4] {
    let k = map.kinematics(TIME, &q, &v, &a);
    let R = so3::rotation(&k.x);
    let T = so3::tangent(&k.x).transpose();
    let (psi, psi_dot): (SVector<f64, 3>, SVector<f64, 3>) = (k.x, k.x_dot);
    let c = pullback_manifold::quotients::Quotients::new(psi.norm());
    let T_dot = so3::T_dot(&psi_dot, &psi, &c).transpose();
    [
        R.column(0).into_owned(),
        R.column(1).into_owned(),
        T * psi_dot,
        T * k.x_ddot + T_dot * psi_dot,
    ]
}
