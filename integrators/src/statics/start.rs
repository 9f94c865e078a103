//! The initial equilibrium of an analysis.
//!
//! Loads that act at the first load parameter (dead weight, a constant pressure) are balanced
//! before they grow, and the equilibrium is reported as step 0. Without such loads nothing is
//! solved or reported.

use super::error::StaticsError;
use super::load_steps::{Known, Summary, settle};
use super::newton::Newton;
use super::stability::unstable;
use super::{Iteration, Step};
use crate::failure::Failure;
use crate::linear_solver::LinearSolver;
use pullback_manifold::system::System;
use std::ops::ControlFlow;

/// Result of the initial equilibrium.
pub(super) struct Beginning {
    pub known: Known,
    pub flow: ControlFlow<()>,
}

/// Balances the loads at `summary.t`, from `q`, and reports the equilibrium if there are any.
///
/// # Errors
/// [`StaticsError::Step`] with the number 0.
pub(super) fn begin<Y: System + ?Sized>(
    newton: &mut Newton,
    solver: &mut dyn LinearSolver,
    system: &mut Y,
    q: &mut [f64],
    summary: &mut Summary,
    observer: &mut dyn FnMut(&mut Y, &Step<'_>) -> ControlFlow<()>,
) -> Result<Beginning, StaticsError> {
    let t = summary.t;
    system.start(t, q);
    summary.chart_changes += system.change_charts(t, q, &mut [], &mut []).charts;
    newton.history.clear();
    let evaluated = newton.evaluate(system, None, q, t).map_err(Failure::System);
    if evaluated.is_ok() && newton.r.iter().all(|r| *r == 0.0) {
        return Ok(Beginning {
            known: Known::Evaluated,
            flow: ControlFlow::Continue(()),
        });
    }
    let mut lambda = t;
    let outcome = evaluated
        .and_then(|()| newton.correct(system, solver, q, &mut lambda, None, None))
        .and_then(|()| settle(newton, solver, system, q, t));
    let chart_changes = match outcome {
        Ok(changes) => changes,
        Err(failure) => {
            let mut failed = newton.fail(system, failure, summary, t);
            failed.step = 0;
            return Err(StaticsError::Step(failed));
        }
    };
    let mut known = Known::Evaluated;
    let mut stability = None;
    if system.is_symmetric() && newton.factorise(solver).is_ok() {
        known = Known::Factorised;
        stability = unstable(newton, solver, system);
    }
    let residuals: Vec<Iteration> = newton.history.clone();
    summary.iterations = newton.iterations();
    summary.chart_changes += chart_changes;
    summary.evaluations = newton.evaluations;
    summary.factorisations = newton.factorisations;
    let report = Step {
        number: 0,
        t,
        step_size: 0.0,
        q,
        iterations: summary.iterations,
        residuals: &residuals,
        chart_changes,
        event: None,
        unstable: stability,
    };
    let flow = observer(system, &report);
    Ok(Beginning { known, flow })
}
