//! The laws of one joint: those of its map, of its coordinates and of its rotation.

use crate::maps::{TIME, laws_behind_slices, short_name, within};
use crate::vectors::norm;
use crate::{Random, Report};
use nalgebra::SVector;
use pullback_elements::joint::{Joint, JointMap};
use pullback_manifold::map::Parametrization;

/// Largest difference from 1 of the square of a quaternion's length, a product of several.
const UNIT: f64 = 1e-12;
/// A column of B below this part of the largest is zero.
const STILL: f64 = 1e-14;

/// Checks a joint at every position within its domain: the laws of its map, that its quaternion has unit length, that
/// the child has the axes of its parent in the reference configuration, and that it moves with each of its coordinates.
pub fn joint<J, const D: usize>(joint: &J) -> Report
where
    J: Joint<D> + Clone + 'static,
{
    let mut report = Report::new(short_name::<J>());
    let mut random = Random::default();
    let mut map = JointMap::new(joint.clone()).between_charts();
    let of_joint = |q: &[f64]| SVector::<f64, D>::from_column_slice(&q[6..]);
    let margin = |q: &[f64]| joint.domain(TIME, &of_joint(q)).unwrap_or(0.0);
    if joint.domain(0.0, &SVector::zeros()).is_ok() {
        let start = joint.pose(0.0, &SVector::zeros()).rotation.v;
        let law = "the child has the axes of its parent at q = 0";
        report.defect(law, "the reference", norm(start.as_slice()), UNIT);
    }
    let (law, coordinates) = ("coordinates have names of their own", joint.coordinates());
    let twice = (1..D).find(|&k| coordinates[..k].iter().any(|c| c.0 == coordinates[k].0));
    match twice.map(|k| format!("two have the name {}", coordinates[k].0)) {
        Some(why) => report.impossible(law, "everywhere", why),
        None => report.defect(law, "everywhere", 0.0, 0.0),
    }
    for (at, q) in within(&mut report, &mut random, 6 + D, margin) {
        let (mut x, mut B) = (vec![0.0; 6], vec![0.0; 6 * (6 + D)]);
        map.evaluate(TIME, [&q, &[], &[]], &mut [[&mut x, &mut B]]);
        own(&mut report, joint, at, &of_joint(&q), &B);
        laws_behind_slices(&mut report, &map, at, &q, &mut random);
    }
    report
}

/// The laws of a joint besides those of its map, whose B is given.
fn own<J: Joint<D>, const D: usize>(
    report: &mut Report,
    joint: &J,
    at: &str,
    q: &SVector<f64, D>,
    B: &[f64],
) {
    let turn = joint.pose(TIME, q).rotation;
    let off = (turn.dot(&turn) - 1.0).abs();
    report.defect("the pose's quaternion has unit length", at, off, UNIT);
    // Operators that are not finite are reported by the laws of the map.
    if !B.iter().all(|b| b.is_finite()) {
        return;
    }

    let law = "moves with its coordinates";
    let names = joint.coordinates();
    let names = names.iter().map(|c| c.0);
    let mut columns = B.chunks_exact(6).skip(6).zip(1..).zip(names);
    match columns.find(|((column, _), _)| norm(column) <= STILL * norm(B)) {
        Some(((_, j), name)) => report.impossible(
            law,
            at,
            format!("it does not move with {name} (coordinate {j}) there"),
        ),
        None => report.defect(law, at, 0.0, 0.0),
    }
}
