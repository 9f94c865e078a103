//! The laws of one joint: those of its map, and what it says of its own coordinates.

#![allow(non_snake_case)]

use crate::maps::{TIME, laws, short_name, within};
use crate::sample::CLEARANCE;
use crate::{Random, Report};
use nalgebra::{SMatrix, SVector};
use pullback_elements::joint::{Joint, JointMap, Released};
use pullback_manifold::map::Map;
use std::collections::HashSet;

/// How far from 1 the square of a quaternion's length may be: it is a product of some.
const UNIT: f64 = 1e-12;
/// A column of B below this part of the largest is zero.
const STILL: f64 = 1e-14;

/// Checks a joint at every position within its domain: the laws of its map, that its rotation is one, and
/// that each of its coordinates moves it.
pub fn joint<J, const D: usize>(joint: &J) -> Report
where
    J: Joint<D> + Clone + 'static,
{
    let mut report = Report::new(short_name::<J>());
    let mut random = Random::default();
    let map = JointMap::new(joint.clone());
    for (at, q) in within(&mut report, &mut random, |q| joint.margin(TIME, q)) {
        let B = map.tangent(TIME, &q).B;
        own(&mut report, joint, at, (TIME, &q), &B);
        if map.margin(TIME, &q) > CLEARANCE {
            laws(&mut report, "", &map, at, TIME, &q, &mut random);
        }
    }
    report
}

/// Notes the laws of a joint besides those of its map, whose B is given.
fn own<J: Joint<D>, const D: usize>(
    report: &mut Report,
    joint: &J,
    at: &str,
    (t, q): (f64, &SVector<f64, D>),
    B: &SMatrix<f64, 6, D>,
) {
    let released = joint.released();
    let law = "released coordinates";
    // The same everywhere: once is enough.
    if report.rows().iter().all(|row| row.law != law) {
        match complaint(released, D) {
            Some(why) => report.impossible(law, "everywhere", why),
            None => report.defect(law, "everywhere", 0.0, 0.0),
        }
    }
    // Where there are no numbers the laws of every map say so.
    if !B.iter().all(|b| b.is_finite()) {
        return;
    }
    let turn = joint.pose(t, q).rotation;
    let off = (turn.dot(&turn) - 1.0).abs();
    report.defect("the pose's quaternion has unit length", at, off, UNIT);

    let law = "moves with what it releases";
    let count: usize = released.iter().map(|r| r.dim()).sum();
    let mut names = released
        .iter()
        .flat_map(|r| std::iter::repeat_n(r.name(), r.dim()));
    let own = D.saturating_sub(count)..D;
    let still = |j: &usize| B.column(*j).norm() <= STILL * B.norm();
    match own.zip(&mut names).find(|(j, _)| still(j)) {
        Some((j, name)) => report.impossible(
            law,
            at,
            format!("it does not move with {name} (coordinate {}) there", j + 1),
        ),
        None => report.defect(law, at, 0.0, 0.0),
    }
}

/// What is wrong with the list of released coordinates of a joint that takes `dim` in all.
fn complaint(released: &[Released], dim: usize) -> Option<String> {
    let count: usize = released.iter().map(|r| r.dim()).sum();
    let mut seen = HashSet::new();
    if let Some(twice) = released.iter().find(|r| !seen.insert(r.name())) {
        return Some(format!(
            "Joint::released has two of the name {}: give each its own",
            twice.name()
        ));
    }
    let left = dim.checked_sub(count);
    left.is_none_or(|left| left % 6 != 0).then(|| {
        format!(
            "it takes {dim} coordinates, {count} of them by Joint::released: the others must be \
             those of its parents, six of each"
        )
    })
}
