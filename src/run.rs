//! A run: model file in, results out.

mod memory;

pub use memory::{ReachError, Recorded, reach, record_job};

use crate::input::{self, Analysis, EigenvaluePlan, InputError, Job, Plan};
use crate::modes::{self, Eigenvalues, ModelModesError};
use crate::output::{
    Checkpoint, Directory, Ending, OutputError, RecordError, Recorder, ResumeError, Setting,
    is_complete,
};
use crate::solve::{Advance, Counts, Ended, begin, solve};
use crate::warnings;
use pullback_elements::model::Context;
use pullback_integrators::dynamics::{DynamicsError, Progress};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Why a run has no results.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
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
    /// Modes or critical loads at its end, if they were requested and found.
    pub eigenvalues: Option<Eigenvalues>,
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
    run_file(model, out, false, observer)
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
    run_file(model, out, true, observer)
}

fn run_file(
    model: &Path,
    out: Option<&Path>,
    resume: bool,
    observer: &mut dyn FnMut(&Advance<'_>) -> ControlFlow<()>,
) -> Result<Outcome, RunError> {
    let directory = out.map_or_else(|| default_directory(model), Path::to_path_buf);
    let source = model.display().to_string();
    run_job(input::load(model)?, &source, &directory, resume, observer)
}

/// Runs an assembled job, or resumes it from its last checkpoint; `source` is the name of its model file in the
/// results.
///
/// # Errors
/// As [`run`] and [`resume`].
pub fn run_job(
    mut job: Job,
    source: &str,
    directory: &Path,
    resume: bool,
    observer: &mut dyn FnMut(&Advance<'_>) -> ControlFlow<()>,
) -> Result<Outcome, RunError> {
    let mut notes = notes(&job);
    let checkpoint = resume
        .then(|| checkpoint(&mut job, directory))
        .transpose()?;
    // A refused start leaves the directory unchanged.
    let resumed = checkpoint.as_ref().map(|c| c.progress.clone());
    let mut progress = initial_progress(&mut job, resumed)?;
    let warnings = match &checkpoint {
        None => first_warnings(&mut job, &progress, &mut notes),
        Some(_) => Vec::new(),
    };
    let directory = match &checkpoint {
        None => Directory::open(directory)?,
        Some(checkpoint) => Directory::reopen(directory, checkpoint.grids(&job.plan))?,
    };
    let setting = Setting {
        source,
        file: &job.file,
        plan: &job.plan,
        geometry: &job.geometry,
        notes: &notes,
    };
    let (context, probes) = (&mut job.context, std::mem::take(&mut job.probes));
    let mut recorder = Recorder::new(setting, directory, probes, context, warnings)?;
    match checkpoint {
        Some(checkpoint) => recorder.resume(context, checkpoint, &progress)?,
        None => recorder.start(context, &progress)?,
    }
    let mut each =
        |context: &mut Context, step: &Advance<'_>| record(&mut recorder, context, &job.plan, step);
    let ended = solve_recorded(context, &job.plan, &mut progress, &mut each, observer)?;
    if matches!(job.plan, Plan::Dynamic(_)) {
        recorder.checkpoint(context, &progress)?;
    }
    let last = recorder.recording.rows.last();
    let t = last.map_or(job.plan.start(), |row| row.t);
    let (found, ending) = find(context, &progress, job.eigenvalues, ended.ending, observer);
    if let Some(found) = &found {
        recorder.write_eigenvalues(context, progress.state.point(), found)?;
    }
    let rows = recorder.recording.rows.len();
    let (written, warnings) = recorder.finish(&ending, ended.counts)?;
    Ok(Outcome {
        ending,
        counts: ended.counts,
        rows,
        t,
        parameter: job.plan.parameter(),
        warnings,
        directory: written.path().to_owned(),
        files: written.files().to_vec(),
        notes,
        eigenvalues: found,
    })
}

/// Solves, and records every step. A converged state that cannot be evaluated is a failure.
fn solve_recorded(
    context: &mut Context,
    plan: &Plan,
    progress: &mut Progress,
    record: &mut dyn FnMut(&mut Context, &Advance<'_>) -> Result<(), RecordError>,
    observer: &mut dyn FnMut(&Advance<'_>) -> ControlFlow<()>,
) -> Result<Ended, RecordError> {
    let mut unrecorded = None;
    let mut ended = solve(context, plan, progress, &mut |context, step| {
        if let Err(error) = record(context, step) {
            unrecorded = Some(error);
            return ControlFlow::Break(());
        }
        observer(step)
    });
    match unrecorded {
        None => {}
        Some(error @ RecordError::System(_)) => {
            let message = error.to_string();
            ended.ending = Ending::Failed { message };
        }
        Some(error) => return Err(error),
    }
    Ok(ended)
}

/// Finds modes or critical loads at the end of a complete analysis, if they are wanted; without them, why the run has not
/// ended with them.
fn find(
    context: &mut Context,
    progress: &Progress,
    wanted: Option<EigenvaluePlan>,
    ending: Ending,
    observer: &mut dyn FnMut(&Advance<'_>) -> ControlFlow<()>,
) -> (Option<Eigenvalues>, Ending) {
    let (Some(wanted), Ending::Complete) = (wanted, &ending) else {
        return (None, ending);
    };
    let at = progress.state.point();
    let found = match wanted {
        EigenvaluePlan::Modes(options) => {
            let mut search = |dimension| observer(&Advance::search(progress, dimension));
            modes::find(context, at, &options, &mut search).map(Eigenvalues::Modes)
        }
        EigenvaluePlan::Campbell(speed, options) => {
            let q = at.q.to_vec();
            let mut search = || observer(&Advance::search(progress, at.q.len()));
            modes::campbell_diagram(context, q, speed, &options, &mut search)
                .map(|found| Eigenvalues::Campbell(Box::new(found)))
        }
        EigenvaluePlan::Buckling(count) => {
            let mut search = |dimension| observer(&Advance::search(progress, dimension));
            modes::critical_loads(context, at, count, &mut search)
                .map(Eigenvalues::Critical)
                .map_err(ModelModesError::from)
        }
    };
    match found {
        Ok(found) => (Some(found), Ending::Complete),
        Err(error) if error.is_interruption() => (None, Ending::Interrupted { t: at.t }),
        Err(error) => {
            let message = error.to_string();
            (None, Ending::Failed { message })
        }
    }
}

/// The last checkpoint of a job, whose model is in its state afterwards.
fn checkpoint(job: &mut Job, directory: &Path) -> Result<Checkpoint, ResumeError> {
    let Plan::Dynamic(plan) = &job.plan else {
        return Err(ResumeError::Statics);
    };
    let settings = serde_json::to_value(&job.file).unwrap_or_default();
    let checkpoint = Checkpoint::read(directory, &settings, &mut job.context)?;
    let (t, to) = (checkpoint.progress.state.t, plan.options.to);
    // A run may have been killed between its last step and its results.
    match t > to || t == to && is_complete(directory) {
        true => Err(ResumeError::Passed { t, to }),
        false => Ok(checkpoint),
    }
}

/// Notes on the joints and loops of a model, and in statics on its stability.
fn notes(Job { context, plan, .. }: &Job) -> Vec<String> {
    let mut notes = context.descriptions();
    if context.mapped_frames().next().is_some() {
        notes.push(context.mobility().to_string());
    }
    if !matches!(plan, Plan::Dynamic(_)) {
        notes.extend(warnings::stability_unknown(context));
    }
    notes
}

/// The state in which a motion begins, or resumes; nothing in statics.
pub(crate) fn initial_progress(
    job: &mut Job,
    resumed: Option<Progress>,
) -> Result<Progress, DynamicsError> {
    let Plan::Dynamic(plan) = &job.plan else {
        return Ok(Progress::default());
    };
    let mut progress = match resumed {
        Some(progress) => progress,
        None => job.start.motion(&job.context)?,
    };
    begin(&mut job.context, &plan.options, &mut progress)?;
    Ok(progress)
}

/// The warnings about a model at its start; adds to the notes on it.
pub(crate) fn first_warnings(
    job: &mut Job,
    progress: &Progress,
    notes: &mut Vec<String>,
) -> Vec<String> {
    let mut warnings = warnings::strained(job, progress);
    warnings.extend(warnings::unstable_start(job));
    if matches!(job.plan, Plan::Dynamic(_)) {
        notes.extend(warnings::prescribed_start(job));
        warnings.extend(warnings::lines_at_rest(job));
        let Job { context, file, .. } = job;
        warnings.extend(warnings::immobile(context));
        warnings.extend(warnings::corners(file));
        warnings.extend(warnings::too_stiff(context, file, progress));
        warnings.extend(warnings::massless(job, progress));
    } else if !matches!(&job.file.analysis, Analysis::Modes(modes) if modes.after.is_none()) {
        warnings.extend(warnings::unsupported(&job.context));
    }
    warnings
}

/// Records a step, and a checkpoint when it is due.
fn record(
    recorder: &mut Recorder<'_>,
    context: &mut Context,
    plan: &Plan,
    step: &Advance<'_>,
) -> Result<(), RecordError> {
    recorder.record(context, step)?;
    if let (Plan::Dynamic(plan), Some(progress)) = (plan, step.progress)
        && plan.checkpoint_every > 0
        && step.number.is_multiple_of(plan.checkpoint_every)
    {
        recorder.checkpoint(context, progress)?;
    }
    Ok(())
}
