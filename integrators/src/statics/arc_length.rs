//! Pseudo-arc-length continuation (Riks 1979; Keller 1977): positions on a path, tangents, and one step.
//!
//! The path (q, λ)(s) is followed with unit tangents in the norm ‖(q, λ)‖² = Σ (qᵢ/scaleᵢ)²/n +
//! (λ/λ_scale)², which is independent of mesh and units. Each step solves on the hyperplane normal
//! to the tangent at its start, so that limit points in λ are passed.

use super::Iteration;
use super::newton::{Condition, Newton};
use crate::failure::Cause;
use crate::rounding::largest;
use pullback_manifold::system::System;

/// Position on the path with its unit tangent.
#[derive(Clone)]
pub(super) struct Position {
    pub q: Vec<f64>,
    pub lambda: f64,
    /// dq/ds and dλ/ds.
    pub dq: Vec<f64>,
    pub d_lambda: f64,
}

/// The norm of the arc length.
pub(super) struct Norm {
    /// Weight of each coordinate, 1/(n scale²).
    pub weights: Vec<f64>,
    /// Weight of the load, 1/load_scale².
    pub load: f64,
}

impl Norm {
    pub fn dot(&self, a: (&[f64], f64), b: (&[f64], f64)) -> f64 {
        let q: f64 = (a.0.iter().zip(b.0).zip(&self.weights))
            .map(|((a, b), w)| a * b * w)
            .sum();
        q + a.1 * b.1 * self.load
    }

    /// Whether a step was corrected by more than its own length, or its displacements by more than
    /// theirs: its end may lie on another part of the path. If displacements are small beside the
    /// size of the structure, a step is almost a load step.
    pub fn strays(&self, from: &Position, to: &Position, ds: f64) -> bool {
        let (mut corrected, mut predicted) = (0.0, 0.0);
        let ends = to.q.iter().zip(&from.q).zip(&from.dq);
        for (((to, from), dq), w) in ends.zip(&self.weights) {
            let ahead = ds * dq;
            corrected += w * (to - from - ahead).powi(2);
            predicted += w * ahead.powi(2);
        }
        let load = (to.lambda - from.lambda - ds * from.d_lambda).powi(2) * self.load;
        corrected + load > ds * ds || corrected > predicted + LEAST * LEAST
    }
}

/// Cosine between successive tangents below which a step is rejected: a path that turns by more
/// within one step may be another one.
pub(super) const SHARPEST_BEND: f64 = 0.6;
/// Corrections of coordinates over their scales that cannot be another part of the path.
const LEAST: f64 = 1e-12;

impl Newton {
    /// Unit tangent at a position, in the direction of its present one.
    pub(super) fn tangent(
        &mut self,
        system: &mut dyn System,
        at: &mut Position,
        norm: &Norm,
    ) -> Result<(), Cause> {
        self.evaluate(system, None, &at.q, at.lambda)
            .map_err(Cause::System)?;
        self.factorise()?;
        self.solve_rate()?;
        let rate = (self.q_lambda.as_slice(), 1.0);
        let length = norm.dot(rate, rate).sqrt();
        let sense = norm.dot(rate, (&at.dq, at.d_lambda)).signum() / length;
        if !sense.is_finite() {
            return Err(Cause::Diverged);
        }
        for (dq, rate) in at.dq.iter_mut().zip(rate.0) {
            *dq = sense * rate;
        }
        at.d_lambda = sense;
        Ok(())
    }

    /// Predicts along the tangent and corrects on the hyperplane normal to it.
    pub(super) fn advance(
        &mut self,
        system: &mut dyn System,
        at: &Position,
        ds: f64,
        norm: &Norm,
        next: &mut Position,
    ) -> Result<(), Cause> {
        for (q, (q0, dq)) in next.q.iter_mut().zip(at.q.iter().zip(&at.dq)) {
            *q = q0 + ds * dq;
        }
        next.lambda = at.lambda + ds * at.d_lambda;
        let loads = largest(system.pattern(), &self.r_lambda, [0.0; 3]);
        self.history.clear();
        self.history.push(Iteration {
            residual: loads.map(|r| r * (ds * at.d_lambda).abs()),
            ratio: f64::INFINITY,
            correction: ds.abs() * self.size(&at.dq),
            damping: 1.0,
        });
        let c: Vec<f64> = (at.dq.iter().zip(&norm.weights))
            .map(|(dq, w)| dq * w)
            .collect();
        let condition = Condition {
            c: &c,
            c_lambda: at.d_lambda * norm.load,
            q0: &at.q,
            lambda0: at.lambda,
            ds,
        };
        let (q, lambda) = (&mut next.q, &mut next.lambda);
        self.correct(
            system,
            q,
            lambda,
            Some(&condition),
            Some((at.lambda, &at.q)),
        )
    }
}
