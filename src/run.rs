//! A run: model file in, results out.

use crate::input::{self, InputError, Job};
use crate::output::{Directory, Ending, OutputError, Recorder, Setting};
use crate::solve::{Ended, solve};
use pullback_integrators::statics::{StaticsError, Step};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Why a run gave no complete results.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The model file is refused; nothing has been written.
    #[error(transparent)]
    Input(#[from] InputError),
    /// Results cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// How a run ended, with its results written.
#[derive(Debug)]
pub struct Outcome {
    /// How it ended.
    pub ending: Ending,
    /// The solver's failure, if that was it.
    pub failure: Option<StaticsError>,
    /// Converged steps and located events recorded.
    pub rows: usize,
    /// Load parameter of the last of them.
    pub t: f64,
    /// Where the results are.
    pub directory: PathBuf,
    /// Names of the files.
    pub files: Vec<String>,
}

/// Where the results of a model file go unless told otherwise: beside it, `model.out`.
pub fn default_directory(model: &Path) -> PathBuf {
    model.with_extension("out")
}

/// Runs a model file. `observer` sees each converged step after it has been recorded and may stop
/// the run.
///
/// # Errors
/// [`RunError`]. A failure of the solver is no error of the run: it is an [`Outcome`] whose
/// results hold the steps that converged.
pub fn run(
    model: &Path,
    out: Option<&Path>,
    observer: &mut dyn FnMut(&Step<'_>) -> ControlFlow<()>,
) -> Result<Outcome, RunError> {
    let job = input::load(model)?;
    let directory = out.map_or_else(|| default_directory(model), Path::to_path_buf);
    run_job(job, &model.display().to_string(), &directory, observer)
}

/// Runs a job that has been assembled; `source` is what the results call its model file.
///
/// # Errors
/// As [`run`].
pub fn run_job(
    job: Job,
    source: &str,
    directory: &Path,
    observer: &mut dyn FnMut(&Step<'_>) -> ControlFlow<()>,
) -> Result<Outcome, RunError> {
    let Job {
        mut model,
        plan,
        probes,
        geometry,
        output,
        file,
        ..
    } = job;
    let setting = Setting {
        source,
        file: &file,
        plan: &plan,
        geometry: &geometry,
        output,
    };
    let mut recorder = Recorder::new(setting, Directory::open(directory)?, probes, &model)?;
    recorder.start(&mut model)?;
    let mut unwritten = None;
    let solved = solve(&mut model, &plan, &mut |model, step| {
        if let Err(error) = recorder.record(model, step) {
            unwritten = Some(error);
            return ControlFlow::Break(());
        }
        observer(step)
    });
    if let Some(error) = unwritten {
        return Err(error.into());
    }
    let (rows, t) = (
        recorder.rows().len(),
        recorder.rows().last().map_or(plan.start(), |row| row.t),
    );
    let ending = match &solved {
        Ok(ended) => ending(ended, t),
        Err(error) => Ending::Failed {
            message: error.to_string(),
        },
    };
    let summary = solved.as_ref().ok().map(|ended| &ended.summary);
    let written = recorder.finish(&ending, summary)?;
    Ok(Outcome {
        ending,
        failure: solved.err(),
        rows,
        t,
        directory: written.path().to_owned(),
        files: written.files().to_vec(),
    })
}

fn ending(ended: &Ended, t: f64) -> Ending {
    match ended.step_limit {
        _ if ended.summary.finished => Ending::Complete,
        Some(max_steps) if ended.summary.steps >= max_steps => Ending::StepLimit { max_steps, t },
        _ => Ending::Interrupted { t },
    }
}
