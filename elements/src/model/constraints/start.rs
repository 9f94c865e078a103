//! Projection of given coordinates and velocities to those that satisfy the enforced equations.

use crate::model::constraints::enforced::EnforcedEquations;
use crate::model::{Context, Model, ModelError, Node, NodeId, Subject};
use nalgebra::{DMatrix, DVector};
use pullback_manifold::system::{System, SystemError};
use std::collections::HashMap;

/// Largest scaled residual of satisfied equations.
pub(super) const CLOSED: f64 = 1e-11;
/// The same with desired values that may be consistent to some digits only; also the allowed
/// deviation of an initial coordinate from its value, in its size.
pub(super) const FITS: f64 = 1e-9;
/// Largest step to a desired initial value, in its size, unless that takes too many; a correction takes three at once.
pub(super) const STRIDE: f64 = 0.1;
/// Largest value, in sizes of the coordinate, whose rounding error is smaller than [`FITS`].
const FARTHEST: f64 = FITS / f64::EPSILON;

impl Model {
    /// The joint or element that enforces an equation.
    fn enforcing(&self, all: &EnforcedEquations, i: usize) -> Subject {
        let (k, _) = all.of[i];
        let e = &self.elements[k];
        let mut closures = self.reports.iter().filter_map(|report| report.element);
        match closures.any(|closure| closure as usize == k) {
            true => Subject::node(&self.nodes, e.nodes[0]),
            false => Subject::named(e.nodes[0], e.name.clone()),
        }
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
    ///
    /// # Panics
    /// If `held` has a number that is none of an unknown.
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

    /// As [`Context::project_state`] for coordinates, keeping those in `wanted` as well: all if possible, or one group after the
    /// other as long as the equations have a solution. [`Context::descriptions`] gives the initial values of the others.
    ///
    /// # Errors
    /// As [`Context::project_state`].
    pub fn project_positions(
        &mut self,
        t: f64,
        q: &mut [f64],
        held: &[usize],
        wanted: &[Vec<usize>],
    ) -> Result<(), ModelError> {
        let all = wanted.concat();
        let values: Vec<(usize, f64)> = all.iter().map(|&u| (u, q[u])).collect();
        let mut closes = |kept: &[usize]| {
            let mut trial = q.to_vec();
            (self.project_state(t, &mut trial, &mut [], kept)).is_ok()
        };
        let mut kept = [held, &all].concat();
        if !all.is_empty() && !closes(&kept) {
            kept.truncate(held.len());
            for group in wanted {
                kept.extend(group);
                if !closes(&kept) {
                    kept.truncate(kept.len() - group.len());
                }
            }
        }
        self.project_state(t, q, &mut [], &kept)?;
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
        if all.h_dot.amax() == 0.0 {
            return Ok((0.0, String::new()));
        }
        let fastest = (v.iter().enumerate()).map(|(u, v)| v.abs() / self.unit(u));
        let steepest = all.sizes.iter().copied().fold(0.0, f64::max);
        let size = (steepest * fastest.fold(0.0, f64::max)).max(all.h_dot.amax());
        let J = without(&all.J, held);
        let more = least(&J, &(-&all.h_dot));
        for (u, more) in more.iter().enumerate() {
            v[u] += more * self.unit(u);
        }
        let left = &all.h_dot + J * more;
        let worst = left.amax();
        let relative = worst / size.max(worst);
        Ok((relative, self.enforcing(&all, left.iamax()).name))
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

    /// Reports unknowns that do not start with their desired values.
    pub(super) fn report_moved(&mut self, q: &[f64], values: &[(usize, f64)]) {
        for &(u, value) in values {
            if (q[u] - value).abs() > FITS * self.unit(u) {
                let (name, x) = (self.name(u), q[u]);
                self.state.moved.push(format!(
                    "{name} starts at {x:.6}: the loop is not found to close with its value"
                ));
            }
        }
    }

    /// Newton's method for h(t, q) = 0 with the smallest corrections, to rounding; returns the
    /// largest remaining |h|, at most `enough`.
    pub(super) fn close_up(
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
            if worst <= f64::EPSILON || (worst <= enough && worst > 0.5 * last) {
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
            joint: self.enforcing(&all, worst),
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
            let size = quantity.size(length);
            let given = starts.get(&(NodeId(n as u32), k));
            if let Some(&value) = given.filter(|x| x.is_nan() || x.abs() > FARTHEST * size) {
                return Err(ModelError::FarStart {
                    coordinate: Subject::coordinate(nodes, n as u32, k),
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
