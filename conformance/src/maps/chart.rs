//! The laws of a chart of rotations: coordinates and quaternions determine each other, and a change of
//! coordinates keeps the motion.

use super::map::{TIME, laws, short_name, within};
use crate::report::Report;
use crate::sample::{CLEARANCE, Random};
use nalgebra::Vector3;
use pullback_manifold::chart::{Charted, RotationChart};
use pullback_manifold::map::{Map, Reparametrization};
use pullback_manifold::quotients::Quotients;
use pullback_manifold::so3::{self, Quaternion};
use std::f64::consts::{PI, TAU};

/// Coordinates are recovered to this fraction of their size.
///
/// A logarithm loses at most the inverse of the distance 0.3 to the edge of its chart; some ten
/// operations of 1e-16 each remain below 1e-14.
const RECOVERED: f64 = 1e-12;
/// An angle that a frame has passed at the end of a step, before its chart changes.
const BEYOND: f64 = PI + 0.1;

/// Checks every law of a chart, and of the map [`Charted`] from its coordinates to the rotation vector,
/// at every position inside both.
pub fn chart<C: RotationChart>(chart: &C) -> Report {
    let mut report = Report::new(short_name::<C>());
    let mut random = Random::default();
    let vector = |q: &[f64]| Vector3::from_column_slice(q);
    let margin = |q: &[f64]| chart.margin(&vector(q));
    let mut positions = within(&mut report, &mut random, 3, margin);
    if positions.is_empty() {
        return report;
    }
    let at = "beyond half a turn";
    let turn = so3::quaternion(&random.of_norm(BEYOND));
    let q = chart.coordinates(&turn);
    let law = "rotations beyond half a turn have coordinates";
    if margin(q.as_slice()) > 0.0 {
        recovered(&mut report, law, at, chart, &turn);
        positions.push((at, q.as_slice().to_vec()));
    } else {
        report.impossible(law, at, "they are outside the domain");
    }
    for (at, q) in positions {
        let q = vector(&q);
        let turn = chart.quaternion(&q);
        if TAU - so3::log_quaternion(&turn).norm() <= CLEARANCE {
            continue;
        }
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
        let law = "the opposite has coordinates of its own";
        recovered(&mut report, law, at, chart, &turn.opposite());
        change(&mut report, "chart to opposite", at, &mut map, [q, v, a]);
    }
    report
}

/// Checks that a quaternion is that of its coordinates, and not its opposite.
fn recovered<C: RotationChart>(
    report: &mut Report,
    law: &str,
    at: &str,
    chart: &C,
    turn: &Quaternion<f64>,
) {
    let found = chart.quaternion(&chart.coordinates(turn));
    let gap = (found.v - turn.v).norm() + (found.w - turn.w).abs();
    report.defect(law, at, gap, RECOVERED);
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
    let c = Quotients::new(k.x.norm());
    let T_dot = so3::T_dot(&k.x_dot, &k.x, &c).transpose();
    [
        R.column(0).into_owned(),
        R.column(1).into_owned(),
        T * k.x_dot,
        T * k.x_ddot + T_dot * k.x_dot,
    ]
}
