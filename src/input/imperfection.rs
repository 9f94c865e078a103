//! Geometric imperfections: the reference configuration displaced by shapes of an earlier run.

use super::file::{Imperfection, ModelFile};
use super::names::Names;
use super::{InputError, InputProblem, Location};
use nalgebra::{Matrix3, Rotation3, Vector3};
use pullback_elements::model::ReferenceCurve;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Displacement and small rotation of a node, global components.
pub(super) type Offset = [Vector3<f64>; 2];

/// What is read of `buckling.json` and `modes.json`.
#[derive(Deserialize)]
struct Shapes {
    modes: Vec<Shape>,
}

#[derive(Deserialize)]
struct Shape {
    nodes: BTreeMap<String, Offset>,
}

/// The sum of all imperfections of a file, by node; nothing without any.
pub(super) fn offsets(
    root: &Location<'_>,
    file: &ModelFile,
) -> Result<Option<Names<Offset>>, InputError> {
    let mut sum: BTreeMap<String, Offset> = BTreeMap::new();
    for (k, imperfection) in file.imperfections.iter().enumerate() {
        let at = root.at("imperfections").at(k);
        let nodes = shape(&at, imperfection)?;
        let largest = |k: usize| nodes.values().map(|o| o[k].norm()).fold(0.0, f64::max);
        let factor = imperfection.amplitude / largest(0);
        // Also of torsion alone, whose displacements are rounding errors.
        if !factor.is_finite() || factor.abs() * largest(1) > 1.0 {
            let expected = "that of a shape that displaces nodes, and turns none by more than a \
                            radian";
            return Err(at.range("amplitude", imperfection.amplitude, expected));
        }
        for (name, offset) in nodes {
            let total = sum.entry(name).or_default();
            *total = [0, 1].map(|i| total[i] + offset[i] * factor);
        }
    }
    let names = Names::of("node of the shape", sum);
    Ok(Some(names).filter(|_| !file.imperfections.is_empty()))
}

/// The nodes of a shape; a relative path begins at the directory of the model file.
fn shape(
    at: &Location<'_>,
    imperfection: &Imperfection,
) -> Result<BTreeMap<String, Offset>, InputError> {
    let path = at.directory().join(&imperfection.shapes);
    let refuse = |message: String| {
        let path = path.clone();
        (at.at("shapes")).refuse(InputProblem::Shapes { path, message })
    };
    let bytes = std::fs::read(&path).map_err(|error| refuse(error.to_string()))?;
    let read: Shapes = serde_json::from_slice(&bytes).map_err(|error| refuse(error.to_string()))?;
    let mode = imperfection.mode;
    let chosen = mode
        .checked_sub(1)
        .and_then(|k| read.modes.into_iter().nth(k));
    let expected = "the number of a mode of the file, from 1";
    let shape = chosen.ok_or_else(|| at.range("mode", mode as f64, expected))?;
    Ok(shape.nodes)
}

/// The Lagrange polynomials of an order on the nodes 0, 1, 2, …, at u.
pub(crate) fn lagrange(order: usize, u: f64) -> impl Iterator<Item = f64> {
    (0..=order).map(move |i| {
        let others = (0..=order).filter(|&j| j != i);
        let factors = others.map(|j| (u - j as f64) / (i as f64 - j as f64));
        factors.product()
    })
}

/// A curve displaced and turned by offsets of equidistant nodes, interpolated in each element.
pub(super) struct Displaced {
    pub curve: Box<dyn ReferenceCurve>,
    /// Of all nodes, from start to end.
    pub offsets: Vec<Offset>,
    /// Order of the elements.
    pub order: usize,
}

impl ReferenceCurve for Displaced {
    fn at(&self, u: f64) -> (Vector3<f64>, Matrix3<f64>) {
        let (X, frame) = self.curve.at(u);
        let intervals = self.offsets.len() - 1;
        let s = u * intervals as f64;
        let first = (s as usize).min(intervals - 1) / self.order * self.order;
        let mut sum = Offset::default();
        for (N, offset) in lagrange(self.order, s - first as f64).zip(&self.offsets[first..]) {
            sum = [0, 1].map(|k| sum[k] + offset[k] * N);
        }
        (X + sum[0], Rotation3::new(sum[1]).matrix() * frame)
    }
}
