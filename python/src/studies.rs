//! Schemes side by side, and their spectra, as JSON.

use super::{ModelError, Watch, assemble, failed, refused, watched};
use pullback::input::job;
use pullback::studies::compare::{Candidate, CompareError, ComparisonOptions, Hooks};
use pullback::studies::{compare as comparison, spectrum};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::Mutex;

fn unusable(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Runs schemes side by side on a model, with all files in a directory if there is one.
#[pyfunction]
#[pyo3(signature = (text, name, schemes, steps, *, reference, workers, timed, out, tell))]
#[allow(
    clippy::too_many_arguments,
    reason = "the keywords of Python's function"
)]
pub(super) fn compare(
    py: Python<'_>,
    text: &str,
    name: &str,
    schemes: Vec<String>,
    steps: Vec<f64>,
    reference: Option<String>,
    workers: Option<NonZeroUsize>,
    timed: bool,
    out: Option<String>,
    tell: Option<Py<PyAny>>,
) -> PyResult<String> {
    let schemes: Result<Vec<Candidate>, _> = schemes.iter().map(|word| word.parse()).collect();
    let reference = reference.map(|word| word.parse()).transpose();
    let options = ComparisonOptions {
        reference: reference.map_err(unusable)?,
        threads: workers,
        timed,
        ..ComparisonOptions::new(schemes.map_err(unusable)?, steps)
    };
    let mut watch = Watch::new(tell.as_ref());
    py.detach(|| {
        let file = assemble(text, name)?.file;
        let make = |formulation| job(name, &file, Some(formulation));
        let done = Mutex::new(0.0);
        let ended = |count, all, _: &str| {
            if let Ok(mut done) = done.lock() {
                *done = count as f64 / all as f64;
            }
        };
        let progress = || done.lock().map_or(0.0, |done| *done);
        let found = watched(&mut watch, &mut || Ok(progress()), |flow| {
            let hooks = Hooks {
                flow,
                ended: &ended,
                ..Hooks::NONE
            };
            match &out {
                Some(out) => comparison::run(&make, name, None, Path::new(out), &options, &hooks),
                None => comparison::compare(&make, name, &options, &hooks),
            }
        })?;
        match found {
            Ok(found) => serde_json::to_string(&found).map_err(failed),
            Err(CompareError::Input(error)) => Err(refused(error)),
            Err(error @ CompareError::Static) => Err(ModelError::new_err(error.to_string())),
            Err(error) => Err(unusable(error)),
        }
    })
}

/// Spectra of schemes.
#[pyfunction]
pub(super) fn spectra(py: Python<'_>, schemes: Vec<String>, range: [f64; 2]) -> PyResult<String> {
    py.detach(|| {
        let all = spectrum::all(&schemes, range).map_err(unusable)?;
        let all: Vec<_> = all.iter().map(|(_, spectrum)| spectrum).collect();
        serde_json::to_string(&all).map_err(failed)
    })
}
