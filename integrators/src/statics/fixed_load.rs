//! One step of the load: predict, correct, settle charts.

use super::Iteration;
use super::newton::Newton;
use crate::abilities::{change_charts, events};
use crate::failure::Cause;
use crate::linear_solver::LinearSolver;
use crate::rounding::largest;
use pullback_manifold::system::{ChartChanges, Point, System};

/// Largest number of corrections after changes of chart.
const ROUNDS: usize = 20;

/// Part of the excursion of a slide from its line, at which equilibrium on the next one is sought.
const BEYOND: f64 = 0.1;

/// State of the tangent at the beginning of a step.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum TangentStatus {
    Nothing,
    Evaluated,
    Factorised,
}

/// The coordinate that moves most between two states, and its value where a slide passes the first end of its line; `None` if
/// none does.
fn departure(system: &mut dyn System, t: f64, from: &[f64], to: &[f64]) -> Option<(usize, f64)> {
    // As in a motion from rest to rest in a unit of time.
    let by = events(system).value(Point::statics(t - 1.0, from), Point::statics(t, to));
    let s = 1.0 - by;
    let coordinates = system.pattern().coordinates();
    let moved = |i: &usize| ((from[*i] - to[*i]) / coordinates[*i].size).abs();
    let most = (0..to.len()).max_by(|a, b| moved(a).total_cmp(&moved(b)));
    most.filter(|_| by >= 0.0)
        .map(|i| (i, from[i] + (to[i] - from[i]) * s * s * (3.0 - 2.0 * s)))
}

impl Newton {
    /// The first correction, with the tangent at the old load.
    pub(super) fn predict(
        &mut self,
        system: &mut dyn System,
        q: &mut [f64],
        [from, to]: [f64; 2],
        known: TangentStatus,
    ) -> Result<(), Cause> {
        self.history.clear();
        if known == TangentStatus::Nothing {
            self.evaluate(system, None, q, from)
                .map_err(Cause::System)?;
        }
        if known != TangentStatus::Factorised {
            self.factorise()?;
        }
        // δq = K⁻¹ (r + r_t Δt): with r_t a prescribed support bends the whole structure, while the
        // residual alone would first strain the element next to it.
        for ((dq, r), rate) in self.dq.iter_mut().zip(&self.r).zip(&self.r_t) {
            *dq = r + rate * (to - from);
        }
        let residual = largest(system.pattern(), &self.dq, [0.0; 3]);
        let solved = self.solver.solve(Some(&self.S), &mut self.dq);
        solved.map_err(Cause::linear)?;
        for (q, dq) in q.iter_mut().zip(&self.dq) {
            *q += dq;
        }
        self.history.push(Iteration {
            residual,
            ratio: f64::INFINITY,
            correction: self.size(&self.dq),
            damping: 1.0,
        });
        Ok(())
    }

    /// Iterates to equilibrium at a fixed load, changes charts if needed, and restores equilibrium
    /// if the discretisation of an element depends on them, so that results do not depend on the
    /// path. The number of changes of chart.
    ///
    /// Where equilibrium moves an element back over its border, both charts are as good. A slide that goes back and forth is
    /// outside of its line on either side: it rests at the node between them, where the force along its chain jumps.
    pub(super) fn settle(
        &mut self,
        system: &mut dyn System,
        q: &mut [f64],
        t: f64,
        previous: Option<(f64, &[f64])>,
    ) -> Result<usize, Cause> {
        self.correct(system, q, &mut { t }, None, previous)?;
        let changes = self.settle_charts(system, q, t);
        self.held.clear();
        changes
    }

    /// The same behind the first equilibrium.
    fn settle_charts(
        &mut self,
        system: &mut dyn System,
        q: &mut [f64],
        t: f64,
    ) -> Result<usize, Cause> {
        let (mut changes, mut left, mut stayed) = (0, None, false);
        for _ in 0..ROUNDS {
            let changed = change_charts(system, t, q, &mut [], &mut []);
            changes += changed.charts;
            if changed == ChartChanges::default() {
                return Ok(changes);
            }
            let before = q.to_vec();
            self.correct(system, q, &mut { t }, None, None)?;
            let Some((i, border)) = departure(system, t, &before, q) else {
                if stayed {
                    return Ok(changes);
                }
                stayed = true;
                continue;
            };
            stayed = false;
            let moved = q[i] - before[i];
            if left.is_some_and(|(k, before)| k == i && moved * before < 0.0) {
                changes += self.rest(system, q, t, (i, border), moved)?;
            }
            left = Some((i, moved));
        }
        Err(Cause::TooManyIterations)
    }

    /// Holds a slide at the border of its line, unless equilibrium on the line beyond is found from there.
    fn rest(
        &mut self,
        system: &mut dyn System,
        q: &mut [f64],
        t: f64,
        (i, border): (usize, f64),
        moved: f64,
    ) -> Result<usize, Cause> {
        q[i] = border;
        self.held.push((i, border));
        self.correct(system, q, &mut { t }, None, None)?;
        let corner = q.to_vec();
        self.held.pop();
        q[i] += BEYOND * moved;
        let beyond = q.to_vec();
        let changed = change_charts(system, t, q, &mut [], &mut []);
        let found = self.correct(system, q, &mut { t }, None, None);
        if found.is_err() || departure(system, t, &beyond, q).is_some() {
            q.copy_from_slice(&corner);
            self.held.push((i, border));
            self.correct(system, q, &mut { t }, None, None)?;
        }
        Ok(changed.charts)
    }

    /// Factorises the tangent at an equilibrium for the next step, and counts its unstable
    /// directions. A singular tangent fails the next step, if any.
    pub(super) fn prepare(&mut self, system: &dyn System) -> (TangentStatus, Option<usize>) {
        if system.is_symmetric() && self.factorise().is_ok() {
            return (TangentStatus::Factorised, self.unstable(system));
        }
        (TangentStatus::Evaluated, None)
    }
}
