//! The initial equilibrium of an analysis.
//!
//! Loads that act at the first load parameter (dead weight, a constant pressure) are balanced
//! before they grow, and the equilibrium is reported as step 0. Without such loads nothing is
//! solved or reported.

use super::Converged;
use super::error::StaticsError;
use super::fixed_load::{Known, settle};
use super::load_steps::StaticSummary;
use super::newton::Newton;
use super::stability::unstable;
use crate::abilities::{change_charts, start};
use crate::failure::Failure;
use crate::linear_solver::LinearSolver;
use pullback_manifold::system::System;

/// Balances the loads at `summary.t`, from `q`: the state of the tangent, and the equilibrium if
/// there are any loads.
///
/// # Errors
/// [`StaticsError::Step`] with the number 0.
pub(super) fn begin(
    newton: &mut Newton,
    solver: &mut dyn LinearSolver,
    system: &mut dyn System,
    q: &mut [f64],
    summary: &mut StaticSummary,
) -> Result<(Known, Option<Converged>), StaticsError> {
    let t = summary.t;
    start(system, t, q);
    summary.chart_changes += change_charts(system, t, q, &mut [], &mut []).charts;
    newton.history.clear();
    let evaluated = newton.evaluate(system, None, q, t).map_err(Failure::System);
    if evaluated.is_ok() && newton.r.iter().all(|r| *r == 0.0) {
        return Ok((Known::Evaluated, None));
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
    summary.iterations = newton.iterations();
    summary.chart_changes += chart_changes;
    summary.evaluations = newton.evaluations;
    summary.factorisations = newton.factorisations;
    let start = Converged {
        number: 0,
        t,
        step_size: 0.0,
        iterations: summary.iterations,
        chart_changes,
        unstable: stability,
    };
    Ok((known, Some(start)))
}
