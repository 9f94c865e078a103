//! Running the analysis of a job: the one place that calls the solvers.

use crate::input::Plan;
use pullback_elements::model::Model;
use pullback_integrators::statics::{StaticsError, Step, Summary, solve_statics, trace_path};
use std::ops::ControlFlow;

/// Where an analysis ended.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ended {
    /// Counts, and whether the end was reached.
    pub summary: Summary,
    /// Most steps allowed, where there is such a limit.
    pub step_limit: Option<usize>,
}

/// Computes what the plan says; `observer` sees every converged step, with the model in its
/// configuration, and may stop the analysis.
///
/// # Errors
/// [`StaticsError`] of the solver.
pub fn solve(
    model: &mut Model,
    plan: &Plan,
    observer: &mut dyn FnMut(&mut Model, &Step<'_>) -> ControlFlow<()>,
) -> Result<Ended, StaticsError> {
    let mut q = Vec::new();
    match plan {
        Plan::Static(options) => Ok(Ended {
            summary: solve_statics(model, &mut q, options, observer)?,
            step_limit: None,
        }),
        Plan::Path(options, _) => Ok(Ended {
            summary: trace_path(model, &mut q, options, observer)?.summary,
            step_limit: Some(options.max_steps),
        }),
    }
}
