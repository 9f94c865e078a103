//! Pseudo-arc-length continuation (Riks 1979; Keller 1977): positions on a path, tangents, and one step.
//!
//! The path (q, t)(s) is followed with unit tangents in the norm ‖(q, t)‖² = Σ (qᵢ/scaleᵢ)²/n +
//! (t/load_scale)², which is independent of mesh and units. Each step solves on the hyperplane normal
//! to the tangent at its start, so that limit points in t are passed.

use super::critical::PathDirection;
use super::newton::{Condition, Newton};
use super::{Event, Iteration};
use crate::failure::Cause;
use crate::rounding::largest;
use pullback_manifold::system::System;

/// Position on the path with its unit tangent.
#[derive(Clone)]
pub(super) struct Position {
    pub q: Vec<f64>,
    pub t: f64,
    /// dq/ds and dt/ds.
    pub tangent: PathDirection,
}

/// The norm of the arc length.
pub(super) struct Norm {
    /// Weight of each coordinate, 1/(n scale²).
    pub weights: Vec<f64>,
    /// Weight of the load, 1/load_scale².
    pub load: f64,
}

impl Norm {
    pub fn dot(&self, a: &PathDirection, b: &PathDirection) -> f64 {
        self.product(a, b.dq.iter().copied(), b.dt)
    }

    /// The product of a direction with (dq, dt).
    pub fn product(&self, a: &PathDirection, dq: impl Iterator<Item = f64>, dt: f64) -> f64 {
        let parts = a.dq.iter().zip(dq).zip(&self.weights);
        parts.map(|((a, b), w)| a * b * w).sum::<f64>() + a.dt * dt * self.load
    }

    /// Distance of (q, t) from a position along its tangent.
    pub fn distance(&self, from: &Position, q: &[f64], t: f64) -> f64 {
        let moved = q.iter().zip(&from.q).map(|(q, q0)| q - q0);
        self.product(&from.tangent, moved, t - from.t)
    }

    /// Whether a step was corrected by more than its own length, or its displacements by more than
    /// theirs: its end may lie on another part of the path. If displacements are small beside the
    /// size of the structure, a step is almost a load step.
    pub fn strays(&self, from: &Position, to: &Position, ds: f64) -> bool {
        let (mut corrected, mut predicted) = (0.0, 0.0);
        let ends = to.q.iter().zip(&from.q).zip(&from.tangent.dq);
        for (((to, from), dq), w) in ends.zip(&self.weights) {
            let ahead = ds * dq;
            corrected += w * (to - from - ahead).powi(2);
            predicted += w * ahead.powi(2);
        }
        let load = (to.t - from.t - ds * from.tangent.dt).powi(2) * self.load;
        corrected + load > ds * ds || corrected > predicted + LEAST * LEAST
    }

    /// 1 for the direction of a branch, or −1 for the opposite one: towards growing loads, or where the first of the largest
    /// components of a symmetric branch, in sizes of the coordinates, is positive.
    pub fn sense(&self, branch: &PathDirection) -> f64 {
        if branch.dt != 0.0 {
            return branch.dt.signum();
        }
        let n = self.weights.len() as f64;
        let parts = branch.dq.iter().zip(&self.weights);
        let parts: Vec<f64> = parts.map(|(x, w)| x * (w * n).sqrt()).collect();
        let largest = parts.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let mut first = parts.iter().filter(|x| x.abs() >= EQUAL * largest);
        first.next().map_or(1.0, |x| x.signum())
    }
}

/// Ratio from which on two components are equal but for rounding errors.
const EQUAL: f64 = 0.999;

/// Cosine between successive tangents below which a step is rejected: a path that turns by more
/// within one step may be another one.
pub(super) const SHARPEST_BEND: f64 = 0.6;
/// Corrections of coordinates over their scales that cannot be another part of the path, where they turn back or rest.
const LEAST: f64 = 1e-8;

impl Newton {
    /// Unit tangent at a position, in the direction of its present one.
    pub(super) fn tangent(
        &mut self,
        system: &mut dyn System,
        at: &mut Position,
        norm: &Norm,
    ) -> Result<(), Cause> {
        self.evaluate(system, None, &at.q, at.t)
            .map_err(Cause::System)?;
        self.factorise()?;
        self.solve_rate()?;
        let length = norm.dot(&self.rate, &self.rate).sqrt();
        let sense = norm.dot(&self.rate, &at.tangent).signum() / length;
        if !sense.is_finite() {
            return Err(Cause::Diverged);
        }
        for (dq, rate) in at.tangent.dq.iter_mut().zip(&self.rate.dq) {
            *dq = sense * rate;
        }
        at.tangent.dt = sense;
        Ok(())
    }

    /// Predicts along the tangent and corrects on the hyperplane normal to it, or to the load or coordinate of an event.
    pub(super) fn advance(
        &mut self,
        system: &mut dyn System,
        at: &Position,
        ds: f64,
        end: Option<Event>,
        norm: &Norm,
        next: &mut Position,
    ) -> Result<(), Cause> {
        for (q, (q0, dq)) in next.q.iter_mut().zip(at.q.iter().zip(&at.tangent.dq)) {
            *q = q0 + ds * dq;
        }
        next.t = at.t + ds * at.tangent.dt;
        let condition = match end {
            Some(Event::Load(load)) => {
                next.t = load;
                None
            }
            Some(Event::Coordinate { unknown, value }) => {
                Some(Condition::Coordinate { unknown, value })
            }
            _ => Some(Condition::Distance { at, norm, ds }),
        };
        let loads = largest(system.pattern(), &self.r_t, [0.0; 3]);
        self.history.clear();
        self.history.push(Iteration {
            residual: loads.map(|r| r * (ds * at.tangent.dt).abs()),
            ratio: f64::INFINITY,
            correction: ds.abs() * self.size(&at.tangent.dq),
            damping: 1.0,
        });
        let (q, t) = (&mut next.q, &mut next.t);
        self.correct(system, q, t, condition.as_ref(), Some((at.t, &at.q)))
    }
}
