//! A run: model file in, results out.

use crate::input::{self, InputError, Job, ModelFile, Plan};
use crate::output::{
    Checkpoint, Directory, Ending, OutputError, RecordError, Recorder, ResumeError, Setting,
    is_complete,
};
use crate::solve::{Advance, Counts, Ended, SolveError, begin, solve};
use crate::warnings;
use pullback_elements::model::Context;
use pullback_integrators::dynamics::{DynamicsError, Progress, start};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Why a run has no results.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The model file is refused; nothing has been written.
    #[error(transparent)]
    Input(#[from] InputError),
    /// There is no valid checkpoint; nothing has been written.
    #[error(transparent)]
    Resume(#[from] ResumeError),
    /// The motion cannot begin.
    #[error(transparent)]
    Start(#[from] DynamicsError),
    /// Results cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
}

impl From<OutputError> for RunError {
    fn from(error: OutputError) -> Self {
        Self::Record(error.into())
    }
}

/// How a run ended, with its results written.
#[derive(Debug)]
pub struct Outcome {
    /// How it ended.
    pub ending: Ending,
    /// The failure of the solver, if any.
    pub failure: Option<SolveError>,
    /// Statistics of the analysis.
    pub counts: Counts,
    /// Converged steps and located events recorded.
    pub rows: usize,
    /// Load parameter or time of the last of them.
    pub t: f64,
    /// Name of that parameter.
    pub parameter: &'static str,
    /// Warnings.
    pub warnings: Vec<String>,
    /// Notes on the loops of the model and their initial coordinates.
    pub notes: Vec<String>,
    /// Directory of the results.
    pub directory: PathBuf,
    /// Names of the files.
    pub files: Vec<String>,
}

/// Default directory of the results of a model file: `model.out` beside it.
pub fn default_directory(model: &Path) -> PathBuf {
    model.with_extension("out")
}

/// Runs a model file. `observer` is called after each converged step has been recorded, and may stop the run.
///
/// # Errors
/// [`RunError`]. A failure of the solver is an [`Outcome`] whose results hold the converged steps.
pub fn run(
    model: &Path,
    out: Option<&Path>,
    observer: &mut dyn FnMut(&Advance<'_>) -> ControlFlow<()>,
) -> Result<Outcome, RunError> {
    let job = input::load(model)?;
    let directory = out.map_or_else(|| default_directory(model), Path::to_path_buf);
    run_job(job, &model.display().to_string(), &directory, observer)
}

/// Resumes a dynamic run from its last checkpoint, with results that are bitwise those of an uninterrupted run.
///
/// # Errors
/// [`RunError`], [`ResumeError`] without a checkpoint of this model in the directory.
pub fn resume(
    model: &Path,
    out: Option<&Path>,
    observer: &mut dyn FnMut(&Advance<'_>) -> ControlFlow<()>,
) -> Result<Outcome, RunError> {
    let job = input::load(model)?;
    let directory = out.map_or_else(|| default_directory(model), Path::to_path_buf);
    resume_job(job, &model.display().to_string(), &directory, observer)
}

/// Runs an assembled job; `source` is the name of its model file in the results.
///
/// # Errors
/// As [`run`].
pub fn run_job(
    job: Job,
    source: &str,
    directory: &Path,
    observer: &mut dyn FnMut(&Advance<'_>) -> ControlFlow<()>,
) -> Result<Outcome, RunError> {
    execute(job, source, directory, None, observer)
}

/// Like [`resume`], for an assembled job.
///
/// # Errors
/// As [`resume`].
pub fn resume_job(
    job: Job,
    source: &str,
    directory: &Path,
    observer: &mut dyn FnMut(&Advance<'_>) -> ControlFlow<()>,
) -> Result<Outcome, RunError> {
    let Plan::Dynamic(plan) = &job.plan else {
        return Err(ResumeError::Statics.into());
    };
    let settings = serde_json::to_value(&job.file).unwrap_or_default();
    let checkpoint = Checkpoint::read(directory, &settings, &job.context)?;
    let (t, to) = (checkpoint.progress().state.t, plan.options.to);
    // A run may have been killed between its last step and its results.
    if t > to || t == to && is_complete(directory) {
        return Err(ResumeError::Passed { t, to }.into());
    }
    execute(job, source, directory, Some(checkpoint), observer)
}

fn execute(
    job: Job,
    source: &str,
    directory: &Path,
    checkpoint: Option<Checkpoint>,
    observer: &mut dyn FnMut(&Advance<'_>) -> ControlFlow<()>,
) -> Result<Outcome, RunError> {
    let Job {
        mut context,
        start: initial,
        plan,
        probes,
        geometry,
        output,
        file,
        ..
    } = job;
    let mut notes = context.descriptions();
    if context.mapped_frames().next().is_some() {
        notes.push(context.mobility().to_string());
    }
    if !matches!(plan, Plan::Dynamic(_)) {
        notes.extend(warnings::stability_unknown(&context));
    }
    // A refused start leaves the directory unchanged.
    let mut progress = Progress::default();
    let mut every = 0;
    if let Plan::Dynamic(plan) = &plan {
        every = plan.checkpoint_every;
        progress = match &checkpoint {
            Some(checkpoint) => {
                checkpoint.restore(&mut context, directory)?;
                checkpoint.progress().clone()
            }
            None => Progress::new(start(&context, 0.0, &initial.q, &initial.v)?),
        };
        begin(&mut context, &plan.options, &mut progress)?;
    }
    if checkpoint.is_none() && matches!(plan, Plan::Dynamic(_)) {
        notes.extend(warnings::carried(&context, &file));
    }
    let warnings = match &checkpoint {
        None => first_warnings(&mut context, &file, &plan, &progress),
        Some(_) => Vec::new(),
    };
    let directory = match &checkpoint {
        None => Directory::open(directory)?,
        Some(checkpoint) => Directory::reopen(directory, &checkpoint.grids())?,
    };
    let setting = Setting {
        source,
        file: &file,
        plan: &plan,
        geometry: &geometry,
        notes: &notes,
        output,
    };
    let mut recorder = Recorder::new(setting, directory, probes, &context, warnings)?;
    match (&plan, checkpoint) {
        (Plan::Dynamic(_), Some(checkpoint)) => {
            recorder.resume(checkpoint)?;
            recorder.look(&mut context, &progress)?;
        }
        (Plan::Dynamic(_), None) => recorder.start_motion(&mut context, &progress)?,
        _ => recorder.start(&mut context)?,
    }
    let mut unwritten = None;
    let ended = solve(&mut context, &plan, &mut progress, &mut |context, step| {
        if let Err(error) = take(&mut recorder, context, step, every) {
            unwritten = Some(error);
            return ControlFlow::Break(());
        }
        observer(step)
    });
    let unevaluated = match unwritten {
        Some(error @ RecordError::System(_)) => Some(error.to_string()),
        Some(error) => return Err(error.into()),
        None => None,
    };
    if matches!(plan, Plan::Dynamic(_)) {
        recorder.checkpoint(&context, &progress)?;
    }
    let rows = recorder.rows().len();
    let t = recorder.rows().last().map_or(plan.start(), |row| row.t);
    let ending = match unevaluated {
        Some(message) => Ending::Failed { message },
        None => ending(&ended, t),
    };
    let mut warnings = recorder.warnings(&ending);
    warnings.extend(warnings::unbalanced(&ended.counts).map(str::to_owned));
    let written = recorder.finish(&ending, ended.counts)?;
    Ok(Outcome {
        ending,
        failure: ended.failure,
        counts: ended.counts,
        rows,
        t,
        parameter: plan.parameter(),
        warnings,
        directory: written.path().to_owned(),
        files: written.files().to_vec(),
        notes,
    })
}

/// The warnings about a model at its start.
fn first_warnings(
    context: &mut Context,
    file: &ModelFile,
    plan: &Plan,
    progress: &Progress,
) -> Vec<String> {
    let mut warnings = warnings::strained(context, file, progress);
    if matches!(plan, Plan::Dynamic(_)) {
        warnings.extend(warnings::left_behind(file));
        warnings.extend(warnings::immobile(context));
        warnings.extend(warnings::massless(context, progress));
        warnings.extend(warnings::drowned(context, file, progress));
    }
    warnings
}

/// Records a step, and a checkpoint when it is due.
fn take(
    recorder: &mut Recorder<'_>,
    context: &mut Context,
    step: &Advance<'_>,
    every: usize,
) -> Result<(), RecordError> {
    recorder.record(context, step)?;
    if let Some(progress) = step.progress
        && every > 0
        && step.number.is_multiple_of(every)
    {
        recorder.checkpoint(context, progress)?;
    }
    Ok(())
}

fn ending(ended: &Ended, t: f64) -> Ending {
    if let Some(failure) = &ended.failure {
        return Ending::Failed {
            message: failure.to_string(),
        };
    }
    match ended.step_limit {
        _ if ended.finished => Ending::Complete,
        Some(max_steps) if ended.counts.steps >= max_steps => Ending::StepLimit { max_steps, t },
        _ => Ending::Interrupted { t },
    }
}
