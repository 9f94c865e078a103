//! The initial equilibrium of an analysis.
//!
//! Loads that act at the first load parameter (dead weight, a constant pressure) are balanced
//! before they grow, and the equilibrium is reported as step 0. Where they are in balance, nothing is
//! solved. Where the first correction is more than a radian or the size of the model, or Newton's method
//! fails, they are balanced in parts: from q₀ to the solution of r(q) = (1 − s) r(q₀), and on from there.

use super::fixed_load::TangentStatus;
use super::load_run::EASY;
use super::newton::Newton;
use super::{StaticsError, Step};
use crate::abilities::charts;
use crate::failure::Cause;
use crate::rounding::is_exact;
use pullback_manifold::system::System;

/// Smallest part.
const SMALLEST: f64 = 1e-6;
/// Most parts, tried or balanced.
const PARTS: usize = 100;

/// Balances the loads at the first load parameter, from `q`: the state of the tangent, and the equilibrium.
///
/// # Errors
/// [`StaticsError::Step`] with the number 0.
pub(super) fn begin(
    newton: &mut Newton,
    system: &mut dyn System,
    q: &mut [f64],
) -> Result<(TangentStatus, Step<'static>), StaticsError> {
    let t = newton.summary.t;
    charts(system).start(t, q);
    newton.summary.chart_changes += charts(system).change_charts(t, q, &mut [], &mut []).charts;
    newton.history.clear();
    let evaluated = newton.evaluate(system, None, q, t).map_err(Cause::System);
    let settled = evaluated.and_then(|()| match is_exact(system, &newton.r) {
        true => Ok(0),
        false => balance(newton, system, q, t),
    });
    let chart_changes = settled.map_err(|failure| {
        let mut failed = newton.fail(system, failure, t);
        failed.step = 0;
        StaticsError::Step(failed)
    })?;
    let (known, unstable) = newton.prepare(system);
    newton.summary.iterations += newton.iterations();
    let iterations = newton.summary.iterations;
    newton.summary.chart_changes += chart_changes;
    let start = Step {
        t,
        iterations,
        chart_changes,
        unstable,
        ..Step::default()
    };
    Ok((known, start))
}

/// Balances the loads at `t`, evaluated at `q`: at once if the first correction is small, and part by part otherwise.
/// Returns the number of changes of chart.
pub(super) fn balance(
    newton: &mut Newton,
    system: &mut dyn System,
    q: &mut [f64],
    t: f64,
) -> Result<usize, Cause> {
    newton.solve(q, t, None)?;
    let mut part = newton.size(&newton.dq).recip().min(1.0);
    let (start, mut from, mut changes) = (q.to_vec(), q.to_vec(), 0);
    for _ in 0..PARTS {
        newton.history.clear();
        let balanced = if part < 1.0 {
            newton.evaluate(system, None, q, t).map_err(Cause::System)?;
            newton.remaining = newton.r.iter().map(|r| (1.0 - part) * r).collect();
            newton
                .correct(system, q, &mut { t }, None, None)
                .map(|()| 0)
        } else {
            newton.settle(system, q, t, None)
        };
        newton.remaining.clear();
        match balanced {
            Ok(last) if part >= 1.0 => return Ok(changes + last),
            Ok(_) => {
                newton.summary.iterations += newton.iterations();
                // The charts of the next part, whose residual is another covector in them.
                changes += charts(system).change_charts(t, q, &mut [], &mut []).charts;
                from.copy_from_slice(q);
                let growth = 1.0 + f64::from(newton.iterations() <= EASY);
                part = (growth * part / (1.0 - part)).min(1.0);
            }
            Err(_) => {
                newton.summary.rejected += 1;
                q.copy_from_slice(&from);
                part *= 0.5;
                if part < SMALLEST {
                    break;
                }
            }
        }
    }
    // All at once, or the rest where charts have changed since.
    if changes == 0 {
        q.copy_from_slice(&start);
    }
    newton.history.clear();
    newton.settle(system, q, t, None).map(|last| changes + last)
}
