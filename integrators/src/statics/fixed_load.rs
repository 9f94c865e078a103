//! One step of the load: predict, correct, settle charts.

use super::Iteration;
use super::newton::Newton;
use crate::abilities::change_charts;
use crate::failure::Cause;
use crate::linear_solver::LinearSolver;
use crate::rounding::largest;
use pullback_manifold::system::{ChartChanges, System};

/// State of the tangent at the beginning of a step.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum TangentStatus {
    Nothing,
    Evaluated,
    Factorised,
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
    pub(super) fn settle(
        &mut self,
        system: &mut dyn System,
        q: &mut [f64],
        t: f64,
        previous: Option<(f64, &[f64])>,
    ) -> Result<usize, Cause> {
        self.correct(system, q, &mut { t }, None, previous)?;
        let mut changes = 0;
        // If equilibrium moves an element back over its border, the second round is the last.
        for _ in 0..2 {
            let changed = change_charts(system, t, q, &mut [], &mut []);
            changes += changed.charts;
            if changed == ChartChanges::default() {
                break;
            }
            self.correct(system, q, &mut { t }, None, None)?;
        }
        Ok(changes)
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
