//! The initial equilibrium of an analysis.
//!
//! Loads that act at the first load parameter (dead weight, a constant pressure) are balanced
//! before they grow, and the equilibrium is reported as step 0. Where they are in balance, nothing is
//! solved. Where the first correction is large, or Newton's method fails, they are balanced in parts:
//! from q₀ to the solution of r(q) = (1 − s) r(q₀), and on from there.

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
    let start = q.to_vec();
    let evaluated = newton.evaluate(system, None, q, t).map_err(Cause::System);
    let mut settled = evaluated.and_then(|()| match is_exact(system, &newton.r) {
        true => Ok(0),
        false => newton.settle(system, q, t, None),
    });
    let first = match (newton.history.first(), &settled) {
        (Some(iteration), _) => iteration.correction,
        (None, Err(Cause::System(_) | Cause::Diverged)) => newton.size(&newton.dq),
        (None, _) => 0.0,
    };
    if first > 1.0 || settled.is_err() && first > 0.0 {
        newton.summary.rejected += 1;
        for in_parts in [true, false] {
            q.copy_from_slice(&start);
            charts(system).start(t, q);
            settled = match in_parts {
                true => balance_in_parts(newton, system, q, t, (1.0 / first).min(0.5)),
                false => newton.settle(system, q, t, None),
            };
            if settled.is_ok() {
                break;
            }
        }
    }
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

/// Balances the loads at `t` part by part, a `part` of the forces out of balance first; returns the number of changes of
/// chart.
fn balance_in_parts(
    newton: &mut Newton,
    system: &mut dyn System,
    q: &mut [f64],
    t: f64,
    mut part: f64,
) -> Result<usize, Cause> {
    let mut changes = 0;
    let mut from = q.to_vec();
    for _ in 0..PARTS {
        newton.history.clear();
        newton.evaluate(system, None, q, t).map_err(Cause::System)?;
        let balanced = if part < 1.0 {
            newton.remaining = newton.r.iter().map(|r| (1.0 - part) * r).collect();
            newton.correct(system, q, &mut { t }, None, None)
        } else {
            let settled = newton.settle(system, q, t, None);
            settled.map(|count| changes += count)
        };
        newton.remaining.clear();
        match balanced {
            Err(cause) => {
                newton.summary.rejected += 1;
                q.copy_from_slice(&from);
                part *= 0.5;
                if part < SMALLEST {
                    return Err(cause);
                }
            }
            Ok(()) if part < 1.0 => {
                newton.summary.iterations += newton.iterations();
                // The charts of the next part, whose residual is another covector in them.
                changes += charts(system).change_charts(t, q, &mut [], &mut []).charts;
                from.copy_from_slice(q);
                let growth = if newton.iterations() <= EASY {
                    2.0
                } else {
                    1.0
                };
                part = (growth * part / (1.0 - part)).min(1.0);
            }
            Ok(()) => return Ok(changes),
        }
    }
    Err(Cause::TooManyIterations)
}
