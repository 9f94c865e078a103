//! A run in memory: no files are written.

use super::{RunError, find, first_warnings, initial_progress, notes, solve_recorded};
use crate::input::{Job, Plan};
use crate::modes::Eigenvalues;
use crate::output::{Ending, History, RecordError, Recording};
use crate::solve::{Advance, Counts, solve};
use pullback_elements::model::Context;
use pullback_integrators::dynamics::{DynamicsError, Progress};
use std::ops::ControlFlow;

/// A run in memory.
#[derive(Debug)]
pub struct Recorded {
    /// How it ended.
    pub ending: Ending,
    /// Statistics of the analysis.
    pub counts: Counts,
    /// Name of the parameter: load parameter or time.
    pub parameter: &'static str,
    /// The history: converged steps and located events.
    pub history: History,
    /// Warnings.
    pub warnings: Vec<String>,
    /// Notes on the model.
    pub notes: Vec<String>,
    /// Modes or critical loads at its end, if they were requested and found.
    pub eigenvalues: Option<Eigenvalues>,
}

/// Runs an assembled job without writing files. `each_row` is called at each row, with the model in its configuration;
/// `observer` after each converged step, and may stop the run.
///
/// # Errors
/// [`RunError::Start`], [`RunError::Record`]. A failure of the solver is the ending of a run that has the
/// converged steps.
pub fn record_job(
    mut job: Job,
    each_row: &mut dyn FnMut(&Context),
    observer: &mut dyn FnMut(&Advance<'_>) -> ControlFlow<()>,
) -> Result<Recorded, RunError> {
    let mut notes = notes(&job);
    let mut progress = initial_progress(&mut job, None)?;
    let warnings = first_warnings(&mut job, &progress, &mut notes);
    let (context, probes) = (&mut job.context, std::mem::take(&mut job.probes));
    let mut recording = Recording::new(&job.plan, probes, warnings);
    let start = recording.start(context, &progress);
    if start.map_err(RecordError::from)?.is_some() {
        each_row(context);
    }
    let mut each = |context: &mut Context, step: &Advance<'_>| {
        if recording.take(context, step)?.is_some() {
            each_row(context);
        }
        Ok(())
    };
    let ended = solve_recorded(context, &job.plan, &mut progress, &mut each, observer)?;
    let (found, ending) = find(context, &progress, job.eigenvalues, ended.ending, observer);
    if let Some(found) = &found {
        let warnings = &mut recording.seen.warnings;
        warnings.extend_from_slice(found.warnings());
    }
    recording.counts = ended.counts;
    Ok(Recorded {
        warnings: recording.warnings(&ending),
        counts: ended.counts,
        parameter: job.plan.parameter(),
        history: recording.history(),
        ending,
        notes,
        eigenvalues: found,
    })
}

/// Why a path is not followed to a load.
const PATH: &str = "a path may pass a load several times; end it there by `stop` instead";

/// Why a job has not reached a state.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReachError {
    /// The motion cannot begin.
    #[error(transparent)]
    Start(#[from] DynamicsError),
    /// The analysis does not pass there.
    #[error("{0}")]
    At(&'static str),
    /// The observer stopped the analysis.
    #[error("interrupted")]
    Interrupted,
    /// The analysis failed, or did not reach its end.
    #[error("{0}")]
    Failed(String),
}

/// Solves a job up to a load parameter or time, or at a speed, by default to the end of its analysis, and leaves its model there;
/// returns the progress, whose state is the one reached.
///
/// # Errors
/// [`ReachError`].
pub fn reach(
    job: &mut Job,
    at: Option<f64>,
    observer: &mut dyn FnMut(&Advance<'_>) -> ControlFlow<()>,
) -> Result<Progress, ReachError> {
    match (&mut job.plan, at) {
        (_, None) => {}
        (_, Some(at)) if !at.is_finite() => {
            return Err(ReachError::At("the load or time must be finite"));
        }
        (Plan::Static(options), Some(at)) => options.to = at,
        (Plan::Steady(_, options), Some(at)) => (options.from, options.to) = (at, at),
        (Plan::Dynamic(plan), Some(at)) => plan.options.to = at,
        (Plan::Path(..), Some(_)) => return Err(ReachError::At(PATH)),
    }
    let mut progress = initial_progress(job, None)?;
    if matches!(job.plan, Plan::Dynamic(_)) && at.is_some_and(|at| at < progress.state.t) {
        return Err(ReachError::At("the motion begins later"));
    }
    let ended = solve(
        &mut job.context,
        &job.plan,
        &mut progress,
        &mut |_, step| observer(step),
    );
    match ended.ending {
        Ending::Interrupted { .. } => Err(ReachError::Interrupted),
        ending => match ending.problem() {
            Some(problem) => Err(ReachError::Failed(problem)),
            None => Ok(progress),
        },
    }
}
