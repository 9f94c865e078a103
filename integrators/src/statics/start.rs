//! The initial equilibrium of an analysis.
//!
//! Loads that act at the first load parameter (dead weight, a constant pressure) are balanced
//! before they grow, and the equilibrium is reported as step 0. Where they are in balance, nothing is
//! solved.

use super::fixed_load::TangentStatus;
use super::newton::Newton;
use super::{StaticsError, Step};
use crate::abilities::charts;
use crate::failure::Cause;
use crate::rounding::is_exact;
use pullback_manifold::system::System;

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
        false => newton.settle(system, q, t, None),
    });
    let chart_changes = settled.map_err(|failure| {
        let mut failed = newton.fail(system, failure, t);
        failed.step = 0;
        StaticsError::Step(failed)
    })?;
    let (known, unstable) = newton.prepare(system);
    let iterations = newton.iterations();
    newton.summary.iterations = iterations;
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
