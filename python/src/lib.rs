//! The native part of the Python package: models as texts, results as NumPy arrays.
//!
//! Classes, plots and tables are Python (`pullback/__init__.py`).

mod eigenvalues;
mod motion;
mod studies;
mod sweep;

use eigenvalues::{eigenvalues, modal};
use numpy::PyArray1;
use pullback::check;
use pullback::elements::model::Context;
use pullback::input::{self, EigenvaluePlan, InputError, Job, Plan, Registry};
use pullback::integrators::linearization::{ModeOptions, Selection};
use pullback::manifold::system::Point;
use pullback::output::Ending;
use pullback::run::{ReachError, Recorded, RunError, reach, record_job, run_job};
use pullback::solve::Advance;
use pullback::{linear, modes};
use pyo3::create_exception;
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::f64::consts::TAU;
use std::ffi::OsString;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

create_exception!(
    pullback,
    ModelError,
    PyValueError,
    "A model is refused; the message has the line of the model file and the cure."
);
create_exception!(
    pullback,
    AnalysisError,
    PyRuntimeError,
    "An analysis failed. `result` holds what has converged, where there is any."
);

/// Time between two looks at signals.
const LOOK: Duration = Duration::from_millis(50);

fn assemble(text: &str, name: &str) -> PyResult<Job> {
    input::assemble_text(name, text).map_err(refused)
}

fn refused(error: InputError) -> PyErr {
    ModelError::new_err(error.report(false))
}

fn failed(error: impl std::fmt::Display) -> PyErr {
    AnalysisError::new_err(error.to_string())
}

/// Looks at signals from time to time, and tells a Python function of the progress.
struct Watch<'a> {
    last: Instant,
    tell: Option<&'a Py<PyAny>>,
    raised: Option<PyErr>,
}

impl<'a> Watch<'a> {
    fn new(tell: Option<&'a Py<PyAny>>) -> Self {
        let (last, raised) = (Instant::now(), None);
        Self { last, tell, raised }
    }

    fn step(&mut self, t: f64) -> ControlFlow<()> {
        if self.last.elapsed() < LOOK {
            return ControlFlow::Continue(());
        }
        self.last = Instant::now();
        let looked = Python::attach(|py| {
            py.check_signals()?;
            self.tell
                .map_or(Ok(()), |tell| tell.call1(py, (t,)).map(drop))
        });
        match looked {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.raised = Some(error);
                ControlFlow::Break(())
            }
        }
    }
}

/// Does some work in another thread, while this one, to which Python delivers signals, looks for them every 2 ms and calls
/// `poll`, which returns the progress.
fn watched<T: Send>(
    watch: &mut Watch<'_>,
    poll: &mut dyn FnMut() -> PyResult<f64>,
    work: impl FnOnce(&(dyn Fn() -> ControlFlow<()> + Sync)) -> T + Send,
) -> PyResult<T> {
    let stopped = AtomicBool::new(false);
    let flow = || match stopped.load(Relaxed) {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    };
    std::thread::scope(|scope| {
        let work = scope.spawn(|| work(&flow));
        while !work.is_finished() && !stopped.load(Relaxed) {
            std::thread::sleep(Duration::from_millis(2));
            match poll() {
                Ok(part) => stopped.store(watch.step(part).is_break(), Relaxed),
                Err(error) => {
                    watch.raised = Some(error);
                    stopped.store(true, Relaxed);
                }
            }
        }
        let found = work.join().map_err(|_| failed("a worker stopped"));
        let last = poll();
        match watch.raised.take() {
            Some(error) => Err(error),
            None => last.and(found),
        }
    })
}

/// Refuses a text that is no model; returns its title, the end of its motion (not a number in statics), and the names
/// of its inputs.
#[pyfunction]
fn inspect(py: Python<'_>, text: &str, name: &str) -> PyResult<(Option<String>, f64, Vec<String>)> {
    py.detach(|| {
        let job = assemble(text, name)?;
        let end = match &job.plan {
            Plan::Dynamic(plan) => plan.options.to,
            _ => f64::NAN,
        };
        Ok((job.file.title, end, job.file.inputs.into_keys().collect()))
    })
}

/// The text with other values of parameters.
#[pyfunction]
fn with_parameters(text: &str, parameters: Vec<(String, String)>) -> PyResult<String> {
    input::with_parameters(text, parameters).map_err(refused)
}

/// The JSON Schema of the model file, as a text.
#[pyfunction]
fn schema() -> String {
    Registry::standard().schema().to_string()
}

/// Runs a model in memory.
#[pyfunction]
fn run<'py>(
    py: Python<'py>,
    text: &str,
    name: &str,
    tell: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let mut poses: Vec<f64> = Vec::new();
    let mut nodes: Vec<String> = Vec::new();
    let mut watch = Watch::new(tell.as_ref());
    let recorded = py.detach(|| -> PyResult<Recorded> {
        let job = assemble(text, name)?;
        nodes.extend(job.context.frames().map(|(_, name)| name.to_owned()));
        let mut each_row = |context: &Context| {
            for (id, _) in context.frames() {
                let state = context.node_state(id);
                poses.extend(state.position.iter().chain(state.psi.iter()));
            }
        };
        let recorded = record_job(job, &mut each_row, &mut |step: &Advance<'_>| {
            watch.step(step.t)
        });
        recorded.map_err(failed)
    })?;
    let out = PyDict::new(py);
    let history = PyDict::new(py);
    for (k, column) in recorded.history.columns.iter().enumerate() {
        history.set_item(column, array(py, recorded.history.column(k).collect()))?;
    }
    out.set_item("history", history)?;
    out.set_item("events", &recorded.history.events)?;
    out.set_item("poses", array(py, poses))?;
    out.set_item("nodes", nodes)?;
    out.set_item("parameter", recorded.parameter)?;
    out.set_item("warnings", &recorded.warnings)?;
    out.set_item("notes", &recorded.notes)?;
    out.set_item("steps", recorded.counts.steps)?;
    out.set_item("iterations", recorded.counts.iterations)?;
    out.set_item("ending", recorded.ending.kind())?;
    out.set_item("message", recorded.ending.problem().unwrap_or_default())?;
    out.set_item("raised", watch.raised)?;
    if let Some(found) = &recorded.eigenvalues {
        out.set_item("eigenvalues", eigenvalues(py, found)?)?;
    }
    Ok(out)
}

/// Runs a model file with all its files in a directory.
#[pyfunction]
fn write(py: Python<'_>, text: &str, name: &str, out: &str) -> PyResult<(bool, String)> {
    let mut watch = Watch::new(None);
    let outcome = py.detach(|| {
        let job = assemble(text, name)?;
        let mut observer = |step: &Advance<'_>| watch.step(step.t);
        run_job(job, name, Path::new(out), false, &mut observer).map_err(|error| match error {
            RunError::Record(_) => PyOSError::new_err(error.to_string()),
            error => failed(error),
        })
    })?;
    if let Some(error) = watch.raised {
        return Err(error);
    }
    let problem = outcome.ending.problem().unwrap_or_default();
    Ok((outcome.ending == Ending::Complete, problem))
}

fn array(py: Python<'_>, values: Vec<f64>) -> Bound<'_, PyArray1<f64>> {
    PyArray1::from_vec(py, values)
}

/// Solves a model up to a state, and does something there.
fn at_state<T: Send>(
    py: Python<'_>,
    (text, name, at): (&str, &str, Option<f64>),
    then: impl FnOnce(&mut Job, Point<'_>) -> PyResult<T> + Send,
) -> PyResult<T> {
    let mut watch = Watch::new(None);
    let found = py.detach(|| {
        let mut job = assemble(text, name)?;
        if let Some(EigenvaluePlan::Campbell(..)) = job.eigenvalues {
            return Err(failed(
                "the equations of a Campbell diagram depend on its speed: run it for their modes, or take \
                 `pullback linearize --at` for their matrices",
            ));
        }
        let reached = reach(&mut job, at, &mut |step| watch.step(step.t));
        match reached {
            Ok(progress) => then(&mut job, progress.state.point()).map(Some),
            Err(ReachError::Interrupted) => Ok(None),
            Err(error) => Err(failed(error)),
        }
    })?;
    found.ok_or_else(|| watch.raised.unwrap_or_else(|| failed("interrupted")))
}

/// The linear equations of motion about a state: rows, columns and values of K, C and M, columns of ∂r/∂u, and names.
#[pyfunction]
fn linearize<'py>(
    py: Python<'py>,
    text: &str,
    name: &str,
    at: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let (lin, inputs, warnings) = at_state(py, (text, name, at), |job, at| {
        let lin = linear::equations(&mut job.context, at).map_err(failed)?;
        let inputs: Vec<String> = job.file.inputs.keys().cloned().collect();
        Ok((lin, inputs, linear::warnings(job, at).map_err(failed)?))
    })?;
    let out = PyDict::new(py);
    for (name, values) in [("K", &lin.K), ("C", &lin.C), ("M", &lin.M)] {
        let entries = || lin.pattern.triplets(values).filter(|(_, _, x)| *x != 0.0);
        let rows: Vec<i64> = entries().map(|(r, _, _)| r as i64).collect();
        let columns: Vec<i64> = entries().map(|(_, c, _)| c as i64).collect();
        let values = entries().map(|(_, _, x)| x).collect();
        let triplets = (
            PyArray1::from_vec(py, rows),
            PyArray1::from_vec(py, columns),
            array(py, values),
        );
        out.set_item(name, triplets)?;
    }
    let columns = lin.r_u.iter().take(inputs.len());
    let columns = columns.map(|r_u| array(py, r_u.clone()));
    out.set_item("r_u", columns.collect::<Vec<_>>())?;
    out.set_item("inputs", inputs)?;
    out.set_item("coordinates", lin.names)?;
    out.set_item("warnings", warnings)?;
    Ok(out)
}

/// Modes about a state.
#[pyfunction]
fn find_modes<'py>(
    py: Python<'py>,
    text: &str,
    name: &str,
    at: Option<f64>,
    count: usize,
    near: f64,
    undamped: bool,
) -> PyResult<Bound<'py, PyDict>> {
    if count == 0 || !(near >= 0.0 && near.is_finite()) {
        let message = "count is 1 or more, and near a frequency, zero or positive";
        return Err(PyValueError::new_err(message));
    }
    let found = at_state(py, (text, name, at), |job, at| {
        let selection = Selection::Nearest {
            count,
            omega: TAU * near,
        };
        let options = ModeOptions {
            selection,
            undamped,
        };
        let mut watch = Watch::new(None);
        let found = modes::find(&mut job.context, at, &options, &mut |_| watch.step(at.t));
        found.map_err(|error| watch.raised.unwrap_or_else(|| failed(error)))
    })?;
    modal(py, &found)
}

/// Verifies a model; its rows as JSON, and whether all are well.
#[pyfunction]
fn verify(py: Python<'_>, text: &str, name: &str, seed: u64) -> PyResult<(String, bool)> {
    let mut watch = Watch::new(None);
    py.detach(|| {
        let mut job = assemble(text, name)?;
        // After Ctrl-C the check is left to its end in another thread.
        let work = std::thread::spawn(move || check::job(&mut job, seed));
        while !work.is_finished() {
            std::thread::sleep(Duration::from_millis(2));
            if watch.step(0.0).is_break() {
                return Err(watch.raised.take().unwrap_or_else(|| failed("interrupted")));
            }
        }
        let report = work.join().map_err(|_| failed("a worker stopped"))?;
        let rows = serde_json::to_string(&check::entries(&report));
        Ok((rows.map_err(failed)?, report.is_ok()))
    })
}

/// Runs the program `pullback` with arguments, of which the first is its name; returns the exit code.
#[pyfunction]
fn program(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| pullback::cli::run(&Registry::standard(), arguments))
}

#[pymodule]
mod _pullback {
    #[allow(non_upper_case_globals, reason = "its name in Python")]
    #[pymodule_export]
    const __version__: &str = env!("CARGO_PKG_VERSION");
    #[pymodule_export]
    use super::motion::{PySaved, PySimulation};
    #[pymodule_export]
    use super::studies::{compare, spectra};
    #[pymodule_export]
    use super::sweep::{PySweep, PyTable};
    #[pymodule_export]
    use super::{
        AnalysisError, ModelError, find_modes, inspect, linearize, program, run, schema, verify,
        with_parameters, write,
    };
    use pyo3::prelude::*;

    /// NumPy is found before the first signal may come: Ctrl-C would break its import within a call.
    #[pymodule_init]
    fn init(m: &Bound<'_, PyModule>) -> PyResult<()> {
        super::array(m.py(), Vec::new());
        m.py()
            .get_type::<super::AnalysisError>()
            .setattr("result", m.py().None())
    }
}
