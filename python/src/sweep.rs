//! Sweeps in threads.

use super::{ModelError, Watch, failed};
use pullback::input::{InputError, Registry};
use pullback::studies::sweep::{Axis, Sweep, SweepError, SweepRow};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// Run, parameters, outcome, load parameter or time, seconds, values.
type Row = (usize, Vec<String>, String, f64, f64, Vec<f64>);

/// A sweep: names of the values, and a row for each of these runs, by default for all.
#[pyfunction]
pub(super) fn sweep(
    py: Python<'_>,
    model: (String, String),
    axes: Vec<(String, Vec<String>)>,
    keep: Vec<String>,
    runs: Option<Vec<usize>>,
    workers: usize,
) -> PyResult<(Vec<String>, Vec<Row>)> {
    let (text, name) = model;
    let keep = keep.iter().map(|word| word.parse());
    let axes = axes.into_iter().map(|(path, values)| Axis { path, values });
    let sweep = keep
        .collect::<Result<_, SweepError>>()
        .and_then(|reductions| Sweep::new(name, text, axes.collect(), reductions))
        .map_err(|error| PyValueError::new_err(error.to_string()))?;
    let runs = runs.unwrap_or_else(|| (0..sweep.len()).collect());
    let mut watch = Watch::new(None);
    let (columns, rows) = py.detach(|| {
        let registry = Registry::standard();
        let refused = |error: InputError| ModelError::new_err(error.report(false));
        let columns = sweep.columns(&registry).map_err(refused)?;
        let rows = watched(&sweep, &registry, (&runs, workers), &mut watch)?;
        Ok::<_, PyErr>((columns, rows.map_err(refused)?))
    })?;
    if let Some(error) = watch.raised {
        return Err(error);
    }
    let rows = rows.into_iter().map(|row| {
        let SweepRow {
            run,
            parameters,
            outcome,
            t,
            seconds,
            values,
        } = row;
        (run, parameters, outcome, t, seconds, values)
    });
    Ok((columns, rows.collect()))
}

/// Runs a sweep while this thread, to which Python delivers signals, looks for them.
fn watched(
    sweep: &Sweep,
    registry: &Registry,
    (runs, workers): (&[usize], usize),
    watch: &mut Watch<'_>,
) -> PyResult<Result<Vec<SweepRow>, InputError>> {
    let stopped = AtomicBool::new(false);
    let flow = || match stopped.load(Relaxed) {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    };
    std::thread::scope(|scope| {
        let work = scope.spawn(|| {
            let mut rows = Vec::new();
            let mut each = |row| {
                rows.push(row);
                ControlFlow::Continue(())
            };
            sweep.run(registry, runs, workers, &mut each, &flow)?;
            rows.sort_by_key(|row: &SweepRow| row.run);
            Ok(rows)
        });
        while !work.is_finished() {
            std::thread::sleep(Duration::from_millis(2));
            if watch.step(0.0).is_break() {
                stopped.store(true, Relaxed);
                break;
            }
        }
        work.join().map_err(|_| failed("a worker stopped"))
    })
}
