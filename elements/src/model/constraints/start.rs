//! Initial states that satisfy the enforced equations: assembly, and projection of given
//! coordinates and velocities.

#![allow(non_snake_case)]

use crate::model::constraints::enforced::EnforcedEquations;
use crate::model::{Context, Model, ModelError, Node, NodeId};
use nalgebra::{DMatrix, DVector};
use pullback_manifold::system::{Charts, Quantity, System, SystemError};
use std::collections::HashMap;

/// Largest scaled residual of satisfied equations.
const CLOSED: f64 = 1e-11;
/// The same with desired values that may be consistent to some digits only; also the allowed
/// deviation of an initial coordinate from its value, in its size.
const FITS: f64 = 1e-9;
/// Rounding errors of scaled residuals.
const ROUNDING: f64 = 1e-14;
/// Largest step to a desired initial value, in its size, unless that takes too many.
const STRIDE: f64 = 0.1;
const STRIDES: f64 = 256.0;
/// Largest value, in sizes of the coordinate, whose rounding error is smaller than [`FITS`].
const FARTHEST: f64 = FITS / f64::EPSILON;
/// Largest coordinates, in their sizes, of a model that is closed as drawn.
const DRAWN: f64 = 1e-6;

impl Model {
    /// The joint or element that enforces an equation.
    fn closing_joint(&self, all: &EnforcedEquations, i: usize) -> String {
        let e = &self.elements[all.of[i].0];
        e.name.trim_start_matches("closure of ").to_owned()
    }
}

impl Context {
    /// Projects a start at time t ([`BEFORE_START`](crate::model::BEFORE_START) of a motion) to the
    /// nearest one that satisfies the enforced equations: coordinates `q`, and velocities `v` if
    /// there are any. The unknowns in `held` do not change. Returns the largest error of a velocity
    /// relative to the size of the velocities: zero to rounding if the equations have a solution.
    ///
    /// # Errors
    /// [`ModelError::Unclosed`] if no configuration nearby satisfies the equations;
    /// [`ModelError::Start`] if one is outside the domain of a joint.
    pub fn project_state(
        &mut self,
        t: f64,
        q: &mut [f64],
        v: &mut [f64],
        held: &[usize],
    ) -> Result<f64, ModelError> {
        if self.model.enforced.is_empty() {
            return Ok(0.0);
        }
        self.close_up(t, q, held, CLOSED)?;
        if v.is_empty() {
            return Ok(0.0);
        }
        let (left, _) = self.project_velocities(t, q, v, held)?;
        Ok(left)
    }

    /// As [`Context::project_state`] for coordinates, keeping those in `wanted` as well if possible; if
    /// not, [`Context::descriptions`] gives their initial values.
    ///
    /// # Errors
    /// As [`Context::project_state`].
    pub fn project_positions(
        &mut self,
        t: f64,
        q: &mut [f64],
        held: &[usize],
        wanted: &[usize],
    ) -> Result<(), ModelError> {
        let mut trial = q.to_vec();
        let all = [held, wanted].concat();
        if !wanted.is_empty() && self.project_state(t, &mut trial, &mut [], &all).is_ok() {
            q.copy_from_slice(&trial);
            return Ok(());
        }
        let values: Vec<(usize, f64)> = wanted.iter().map(|&u| (u, q[u])).collect();
        self.project_state(t, q, &mut [], held)?;
        self.report_moved(q, &values);
        Ok(())
    }

    /// As [`Context::project_state`] for velocities, at coordinates that satisfy the equations; returns the
    /// largest error, and its joint.
    ///
    /// # Errors
    /// [`ModelError::Start`] outside the domain of a joint.
    pub fn project_velocities(
        &mut self,
        t: f64,
        q: &[f64],
        v: &mut [f64],
        held: &[usize],
    ) -> Result<(f64, String), ModelError> {
        if self.model.enforced.is_empty() {
            return Ok((0.0, String::new()));
        }
        let all = self.equations(t, q, v).map_err(start)?;
        let fastest = (v.iter().enumerate()).map(|(u, v)| v.abs() / self.unit(u));
        let steepest = all.sizes.iter().copied().fold(0.0, f64::max);
        let size = steepest * fastest.fold(0.0, f64::max);
        let J = without(&all.J, held);
        let more = least(&J, &(-&all.h_dot));
        for (u, more) in more.iter().enumerate() {
            v[u] += more * self.unit(u);
        }
        let left = &all.h_dot + J * more;
        let worst = left.amax();
        let relative = if worst > 0.0 {
            worst / size.max(worst)
        } else {
            0.0
        };
        Ok((relative, self.closing_joint(&all, left.iamax())))
    }

    /// Whether the enforced equations leave an unknown no freedom at (t, q).
    ///
    /// # Errors
    /// [`ModelError::Start`] outside the domain of a joint.
    pub fn is_locked(&mut self, t: f64, q: &[f64], unknown: usize) -> Result<bool, ModelError> {
        if self.model.enforced.is_empty() {
            return Ok(false);
        }
        let J = self.equations(t, q, &[]).map_err(start)?.J;
        let b = -J.column(unknown).clone_owned();
        let others = without(&J, &[unknown]);
        let left = &b - &others * least(&others, &b);
        Ok(left.amax() > FITS * b.amax())
    }

    /// Assembles the model, and finds the redundant equations.
    ///
    /// Keeps as many of the desired values (unknown, value) as possible, in their order, like the
    /// maps of loops; the report names the others. `positions` is the start of the coordinates of
    /// loops if closed by maps. Returns the initial coordinates.
    pub(in crate::model) fn assemble_enforced(
        &mut self,
        values: &[(usize, f64)],
        positions: &[(u32, usize, f64)],
    ) -> Result<Vec<f64>, ModelError> {
        if self.model.enforced.is_empty() {
            return Ok(vec![0.0; self.model.coordinates.len()]);
        }
        let mut q = match self.as_by_maps(values, positions) {
            Some(q) => q,
            None => self.by_corrections(values)?,
        };
        self.change_charts(0.0, &mut q, &mut [], &mut []);
        self.leave_out_redundant(&q)?;
        self.report_moved(&q, values);
        Ok(q)
    }

    /// The start with all loops closed by maps, if it keeps all desired values.
    fn as_by_maps(
        &mut self,
        values: &[(usize, f64)],
        positions: &[(u32, usize, f64)],
    ) -> Option<Vec<f64>> {
        let mut q = vec![0.0; self.model.coordinates.len()];
        let mut found = Vec::new();
        for &(node, k, x) in positions {
            let u = self.unknown_at(NodeId(node), k)?;
            q[u] = x;
            found.push(u);
        }
        if positions.is_empty() || values.iter().any(|(u, _)| !found.contains(u)) {
            return None;
        }
        let mut kept = Vec::new();
        for &(u, x) in values {
            if (q[u] - x).abs() <= FITS * self.unit(u) {
                q[u] = x;
                kept.push(u);
            }
        }
        self.with_kept(q, kept).ok()
    }

    /// The start by the smallest corrections from the configuration as drawn.
    fn by_corrections(&mut self, values: &[(usize, f64)]) -> Result<Vec<f64>, ModelError> {
        let mut q = vec![0.0; self.model.coordinates.len()];
        self.start_element_charts(0.0, &q);
        let closed = self.close_up(0.0, &mut q, &[], CLOSED);
        if values.is_empty() {
            return closed.map(|_| q);
        }
        let drawn = closed.is_ok().then_some(q);
        self.with_values(drawn.as_deref(), values)
    }

    /// Reports unknowns that do not start with their desired values.
    fn report_moved(&mut self, q: &[f64], values: &[(usize, f64)]) {
        for &(u, value) in values {
            if (q[u] - value).abs() > FITS * self.unit(u) {
                let (name, x) = (self.name(u), q[u]);
                self.state.moved.push(format!(
                    "{name} starts at {x:.6}: the loop is not found to close with its value"
                ));
            }
        }
    }

    /// A configuration that satisfies the equations, with as many of the values as possible.
    /// `drawn` is one without them.
    fn with_values(
        &mut self,
        drawn: Option<&[f64]>,
        values: &[(usize, f64)],
    ) -> Result<Vec<f64>, ModelError> {
        let mut kept = values.to_vec();
        let mut found = self.approach(drawn, values, &kept);
        if found.is_none() {
            kept.clear();
            for &value in values {
                kept.push(value);
                match self.approach(drawn, values, &kept) {
                    None => _ = kept.pop(),
                    some => found = some,
                }
            }
        }
        let q = match (found, drawn) {
            (Some(q), _) => q,
            (None, Some(drawn)) => drawn.to_vec(),
            (None, None) => vec![0.0; self.model.coordinates.len()],
        };
        self.with_kept(q, kept.into_iter().map(|(u, _)| u).collect())
    }

    /// Closes a configuration that is closed to some digits, keeping as many of the unknowns in
    /// `kept` as possible, in their order.
    fn with_kept(&mut self, mut q: Vec<f64>, kept: Vec<usize>) -> Result<Vec<f64>, ModelError> {
        // Attempts at other values may have changed the charts.
        self.start_element_charts(0.0, &q);
        // Values that are consistent to some digits only yield to earlier ones.
        let mut held = Vec::new();
        for u in kept {
            held.push(u);
            let mut trial = q.clone();
            match self.close_up(0.0, &mut trial, &held, CLOSED) {
                Ok(left) if left <= ROUNDING => q = trial,
                _ => _ = held.pop(),
            }
        }
        self.close_up(0.0, &mut q, &held, CLOSED)?;
        Ok(q)
    }

    /// Closes the model with the values in `held`. If it is closed as drawn, they are approached in
    /// steps, on one branch; if that fails, these and all other `values` are a first guess.
    fn approach(
        &mut self,
        drawn: Option<&[f64]>,
        values: &[(usize, f64)],
        held: &[(usize, f64)],
    ) -> Option<Vec<f64>> {
        let fixed: Vec<usize> = held.iter().map(|&(u, _)| u).collect();
        let far = |q: &[f64], u: usize, x: f64| (x - q[u]).abs() / self.unit(u);
        let near = |q: &&[f64]| (0..q.len()).all(|u| far(q, u, 0.0) < DRAWN);
        if let Some(from) = drawn.filter(near) {
            let distances = held.iter().map(|&(u, x)| far(from, u, x));
            let steps = (distances.fold(0.0, f64::max) / STRIDE)
                .ceil()
                .clamp(1.0, STRIDES);
            let mut q = from.to_vec();
            self.start_element_charts(0.0, &q);
            let arrived = (1..=steps as usize).all(|k| {
                let part = k as f64 / steps;
                for &(u, x) in held {
                    q[u] = (1.0 - part) * from[u] + part * x;
                }
                let closed = self.close_up(0.0, &mut q, &fixed, FITS).is_ok();
                self.change_charts(0.0, &mut q, &mut [], &mut []);
                closed
            });
            if arrived {
                return Some(q);
            }
        }
        let mut q = vec![0.0; self.model.coordinates.len()];
        values.iter().for_each(|&(u, x)| q[u] = x);
        self.start_element_charts(0.0, &q);
        let closed = self.close_up(0.0, &mut q, &fixed, FITS);
        closed.ok().map(|_| q)
    }

    /// Newton's method for h(t, q) = 0 with the smallest corrections, to rounding; returns the
    /// largest remaining |h|, at most `enough`.
    fn close_up(
        &mut self,
        t: f64,
        q: &mut [f64],
        held: &[usize],
        enough: f64,
    ) -> Result<f64, ModelError> {
        let mut last = f64::INFINITY;
        for _ in 0..60 {
            let all = self.equations(t, q, &[]).map_err(start)?;
            let worst = all.h.amax();
            if worst == 0.0 || (worst <= enough && worst > 0.5 * last) {
                return Ok(worst);
            }
            last = worst;
            let more = least(&without(&all.J, held), &(-&all.h));
            let shorter = (3.0 * STRIDE / more.amax()).min(1.0);
            for (u, more) in more.iter().enumerate() {
                q[u] += more * shorter * self.unit(u);
            }
        }
        let all = self.equations(t, q, &[]).map_err(start)?;
        let worst = all.h.iamax();
        let (k, i) = all.of[worst];
        let prescribed: Vec<String> = self.prescribed().map(|c| self.coordinate_name(c)).collect();
        Err(ModelError::Unclosed {
            joint: self.closing_joint(&all, worst),
            equation: self.model.elements[k].equation(i),
            gap: all.h.amax(),
            prescribed: prescribed.join(", "),
        })
    }
}

/// Rejects initial values that are too large to resolve positions in a model of this size.
pub(in crate::model) fn check_values(
    nodes: &[Node],
    starts: &HashMap<(NodeId, usize), f64>,
    length: f64,
) -> Result<(), ModelError> {
    for (n, node) in nodes.iter().enumerate() {
        for (k, quantity) in node.quantities.iter().enumerate() {
            let size = if *quantity == Quantity::Angle {
                1.0
            } else {
                length
            };
            let given = starts.get(&(NodeId(n as u32), k));
            if let Some(&value) = given.filter(|x| x.abs() > FARTHEST * size) {
                return Err(ModelError::FarStart {
                    coordinate: node.coordinate_name(k),
                    value,
                    most: FARTHEST * size,
                });
            }
        }
    }
    Ok(())
}

/// Error of the evaluation of a start.
pub(in crate::model) fn start(source: SystemError) -> ModelError {
    ModelError::Start { source }
}

/// The matrix with zeros in the columns of held unknowns.
fn without(J: &DMatrix<f64>, held: &[usize]) -> DMatrix<f64> {
    let mut J = J.clone();
    held.iter().for_each(|&u| J.column_mut(u).fill(0.0));
    J
}

/// The least squares solution of J x = b with the smallest norm.
fn least(J: &DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let gram = (J * J.transpose()).symmetric_eigen();
    let largest = gram.eigenvalues.amax();
    let mut y = gram.eigenvectors.tr_mul(b);
    for (y, e) in y.iter_mut().zip(gram.eigenvalues.iter()) {
        *y = if *e > 1e-14 * largest { *y / e } else { 0.0 };
    }
    J.tr_mul(&(gram.eigenvectors * y))
}
