//! Path from the last converged state to another one, on one branch of solutions.

use super::EvaluationError;
use super::core::{Anchor, ImplicitMap};
use std::f64::consts::PI;

/// Condition number per unknown over the steepest slope below which x is at the limit of a
/// prescribed motion.
const STEEP: f64 = 5.0;
/// Part of the distance to a singular configuration, to first order, that a step may go if q and p turn back.
const AHEAD: f64 = 0.75;
/// Largest predicted change of x in a part: the equations are those at the anchor again after a turn.
const FARTHEST: f64 = 1.0;
/// Largest number of parts of a step.
const PARTS: usize = 64;

impl ImplicitMap {
    /// Solves for x at (q, p) and its operators, into the workspace. Newton's method alone may end
    /// on another branch: if the equations change by too much to exclude that, the path is followed
    /// in smaller parts.
    pub(super) fn follow(&mut self, t: f64, q: &[f64]) -> Result<(), EvaluationError> {
        if self.anchor.closing * (t - self.anchor.t) < -AHEAD && self.turns_back(t, q) {
            return Err(EvaluationError::Crossed);
        }
        let Err(first) = self.part(t, q, true) else {
            return Ok(());
        };
        // A rotation vector that has changed its chart is far away, but x is the same.
        let moved = |j: usize| (q[j] - self.anchor.q[j]).powi(2);
        let far = |k: &usize| (0..3).map(|i| moved(self.D + k + i)).sum::<f64>() > PI * PI;
        let mut parameters = self.about.rotations.iter().filter(|k| **k < self.p);
        if parameters.any(far) && self.part(t, q, false).is_ok() {
            return Ok(());
        }
        if q.iter().any(|q| !q.is_finite()) {
            return Err(first);
        }
        let start = self.anchor.clone();
        let mut parts = 2;
        let outcome = loop {
            let outcome = self.walk(&start, t, q, parts);
            if outcome.is_ok() || parts >= PARTS {
                break outcome;
            }
            parts *= 2;
        };
        let reached = std::mem::replace(&mut self.anchor, start);
        outcome.map_err(|error| match error {
            EvaluationError::Inconsistent { equation, residual } => {
                self.contradicted(equation, residual)
            }
            other => self.explained(&reached, other),
        })
    }

    /// Whether q and p turn back where their velocities at the anchor lead to a singular configuration, at which det A is
    /// zero to first order: the motion may go on there on another branch, while this one has a position at (q, p), too.
    fn turns_back(&mut self, t: f64, q: &[f64]) -> bool {
        let (from, start) = (self.anchor.t, self.anchor.q.clone());
        let h = t - from;
        let mean: Vec<f64> = q.iter().zip(&start).map(|(q, q0)| (q - q0) / h).collect();
        if self.solve(from, &start).is_err() {
            return false;
        }
        self.find_rates(from, &mean);
        self.closing() * h > -AHEAD
    }

    /// Why the path ends at the position reached: at the limit of a prescribed motion, where the slopes
    /// of x grow like the condition number, or at a singular configuration, where they do not.
    fn explained(&mut self, reached: &Anchor, error: EvaluationError) -> EvaluationError {
        let singular = self.close_to_singular(reached);
        if self.p > 0 && (self.D == 0 || singular.is_some()) {
            let slopes = reached.Y.chunks_exact(self.X).skip(self.D);
            let steepest = slopes.fold(0.0, |most, slope| {
                let over = slope.iter().zip(&self.about.unknowns);
                over.fold(most, |most, (y, u)| f64::max(most, (y / u.size).abs()))
            });
            match singular {
                Some(EvaluationError::Singular { condition, .. })
                    if steepest * STEEP * self.X as f64 > condition => {}
                Some(singular) => return singular,
                None => {}
            }
            return EvaluationError::OutOfReach {
                prescribed: self.prescribed(|_| true),
            };
        }
        singular.unwrap_or(error)
    }

    /// Follows equal parts of a straight line from an anchor.
    fn walk(
        &mut self,
        start: &Anchor,
        t: f64,
        q: &[f64],
        parts: usize,
    ) -> Result<(), EvaluationError> {
        self.anchor.clone_from(start);
        for k in 1..=parts {
            let s = k as f64 / parts as f64;
            let part = |a: f64, b: f64| if k < parts { a + s * (b - a) } else { b };
            let next: Vec<f64> = (start.q.iter().zip(q)).map(|(a, b)| part(*a, *b)).collect();
            let then = part(start.t, t);
            self.part(then, &next, true)?;
            self.set_anchor(then, &next);
        }
        Ok(())
    }

    /// One part of the path by Newton's method, predicted by the slopes at its beginning.
    fn part(&mut self, t: f64, q: &[f64], follow: bool) -> Result<(), EvaluationError> {
        if self.predict(q, follow) > FARTHEST && follow {
            return Err(EvaluationError::Crossed);
        }
        self.search(t, q)?;
        self.operators();
        match follow && self.changed() >= 1.0 {
            true => Err(EvaluationError::Crossed),
            false => Ok(()),
        }
    }

    /// Change of the equations since the anchor, ‖(h_x − h_x₀) P₀‖ with scaled equations. Below one, A
    /// is regular on the whole segment between the two positions (Neumann's series); across a singular
    /// configuration, where branches meet, it is at least one, however short the segment.
    fn changed(&self) -> f64 {
        let (p, X, M, w) = (self.p, self.X, self.M, &self.work);
        let used = |i: &usize| self.chart.used[*i];
        let mut squares = 0.0;
        for j in (0..M).filter(used) {
            let P = &self.anchor.P[j * X..(j + 1) * X];
            for i in (0..M).filter(used) {
                let row = P.iter().enumerate();
                let product: f64 = row.map(|(k, P)| w.J[i + (p + k) * M] * P).sum();
                let change = product - f64::from(i == j);
                squares += (change * self.sizes[j] / self.sizes[i]).powi(2);
            }
        }
        squares.sqrt()
    }
}
