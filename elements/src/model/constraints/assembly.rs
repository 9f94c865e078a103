//! Assembly of loops that forces close: a start that keeps as many desired values as possible.

use crate::model::constraints::start::{CLOSED, FITS, STRIDE};
use crate::model::{Context, ModelError, NodeId};
use pullback_manifold::system::Charts;

/// Rounding errors of scaled residuals.
const ROUNDING: f64 = 1e-14;
/// Most steps to a desired initial value.
const STRIDES: f64 = 256.0;
/// Largest coordinates, in their sizes, of a model that is closed as drawn.
const DRAWN: f64 = 1e-6;

impl Context {
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
        let mut assembly = Assembly(self);
        let mut q = match assembly.as_by_maps(values, positions) {
            Some(q) => q,
            None => assembly.by_corrections(values)?,
        };
        self.change_charts(0.0, &mut q, &mut [], &mut []);
        self.leave_out_redundant(&q)?;
        self.report_moved(&q, values);
        Ok(q)
    }
}

/// A model that is assembled.
struct Assembly<'a>(&'a mut Context);

impl Assembly<'_> {
    /// The start with all loops closed by maps, if it keeps all desired values.
    fn as_by_maps(
        &mut self,
        values: &[(usize, f64)],
        positions: &[(u32, usize, f64)],
    ) -> Option<Vec<f64>> {
        let mut q = vec![0.0; self.0.model.coordinates.len()];
        let mut found = Vec::new();
        for &(node, k, x) in positions {
            let u = self.0.unknown_at(NodeId(node), k)?;
            q[u] = x;
            found.push(u);
        }
        if positions.is_empty() || values.iter().any(|(u, _)| !found.contains(u)) {
            return None;
        }
        let mut kept = Vec::new();
        for &(u, x) in values {
            if (q[u] - x).abs() <= FITS * self.0.unit(u) {
                q[u] = x;
                kept.push(u);
            }
        }
        self.with_kept(q, kept).ok()
    }

    /// The start by the smallest corrections from the configuration as drawn.
    fn by_corrections(&mut self, values: &[(usize, f64)]) -> Result<Vec<f64>, ModelError> {
        let mut q = vec![0.0; self.0.model.coordinates.len()];
        self.0.start_element_charts(0.0, &q);
        let closed = self.0.close_up(0.0, &mut q, &[], CLOSED);
        if values.is_empty() {
            return closed.map(|_| q);
        }
        let drawn = closed.is_ok().then_some(q);
        self.with_values(drawn.as_deref(), values)
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
        let q = found.or_else(|| drawn.map(<[f64]>::to_vec));
        let q = q.unwrap_or_else(|| vec![0.0; self.0.model.coordinates.len()]);
        self.with_kept(q, kept.into_iter().map(|(u, _)| u).collect())
    }

    /// Closes a configuration that is closed to some digits, keeping as many of the unknowns in
    /// `kept` as possible, in their order.
    fn with_kept(&mut self, mut q: Vec<f64>, kept: Vec<usize>) -> Result<Vec<f64>, ModelError> {
        // Attempts at other values may have changed the charts.
        self.0.start_element_charts(0.0, &q);
        // Values that are consistent to some digits only yield to earlier ones.
        let mut held = Vec::new();
        for u in kept {
            held.push(u);
            let mut trial = q.clone();
            match self.0.close_up(0.0, &mut trial, &held, CLOSED) {
                Ok(left) if left <= ROUNDING => q = trial,
                _ => _ = held.pop(),
            }
        }
        self.0.close_up(0.0, &mut q, &held, CLOSED)?;
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
        let far = |q: &[f64], u: usize, x: f64| (x - q[u]).abs() / self.0.unit(u);
        let near = |q: &&[f64]| (0..q.len()).all(|u| far(q, u, 0.0) < DRAWN);
        if let Some(from) = drawn.filter(near) {
            let distances = held.iter().map(|&(u, x)| far(from, u, x));
            let steps = (distances.fold(0.0, f64::max) / STRIDE)
                .ceil()
                .clamp(1.0, STRIDES);
            let mut q = from.to_vec();
            self.0.start_element_charts(0.0, &q);
            let arrived = (1..=steps as usize).all(|k| {
                let part = k as f64 / steps;
                for &(u, x) in held {
                    q[u] = (1.0 - part) * from[u] + part * x;
                }
                let closed = self.0.close_up(0.0, &mut q, &fixed, FITS).is_ok();
                self.0.change_charts(0.0, &mut q, &mut [], &mut []);
                closed
            });
            if arrived {
                return Some(q);
            }
        }
        let mut q = vec![0.0; self.0.model.coordinates.len()];
        values.iter().for_each(|&(u, x)| q[u] = x);
        self.0.start_element_charts(0.0, &q);
        let closed = self.0.close_up(0.0, &mut q, &fixed, FITS);
        closed.ok().map(|_| q)
    }
}
