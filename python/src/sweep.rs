//! Sweeps in threads, and their table in a directory.

use super::{Watch, failed, refused, watched};
use pullback::input::Registry;
use pullback::studies::sweep::{Axis, Sweep, SweepError, SweepRow, SweepTable, TableError};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// Run, parameters, outcome, load parameter or time, seconds, values, warnings.
type Row = (usize, Vec<String>, String, f64, f64, Vec<f64>, String);

fn to_python(row: SweepRow) -> Row {
    let (t, seconds, values) = (row.t, row.seconds, row.values);
    let warnings = row.warnings;
    (
        row.run,
        row.parameters,
        row.outcome,
        t,
        seconds,
        values,
        warnings,
    )
}

fn of_python((run, parameters, outcome, t, seconds, values, warnings): Row) -> SweepRow {
    SweepRow {
        run,
        parameters,
        outcome,
        t,
        seconds,
        values,
        warnings,
    }
}

fn unsaved(error: TableError) -> PyErr {
    match error {
        TableError::Other(_) => PyValueError::new_err(error.to_string()),
        error => PyOSError::new_err(error.to_string()),
    }
}

/// One model with many values of its parameters.
#[pyclass(frozen, module = "pullback", name = "Sweep")]
pub(super) struct PySweep {
    sweep: Sweep,
    /// Names of the values of a run.
    #[pyo3(get)]
    columns: Vec<String>,
}

#[pymethods]
impl PySweep {
    #[new]
    fn new(
        model: (String, String),
        axes: Vec<(String, Vec<String>)>,
        keep: Vec<String>,
    ) -> PyResult<Self> {
        let (text, name) = model;
        let keep = keep.iter().map(|word| word.parse());
        let axes = axes.into_iter().map(|(path, values)| Axis { path, values });
        let sweep = keep
            .collect::<Result<_, SweepError>>()
            .and_then(|reductions| Sweep::new(name, text, axes.collect(), reductions))
            .map_err(|error| PyValueError::new_err(error.to_string()))?;
        let columns = sweep.columns(&Registry::standard()).map_err(refused)?;
        Ok(Self { sweep, columns })
    }

    fn __len__(&self) -> usize {
        self.sweep.runs()
    }

    /// The table in a directory, with the rows that it has already.
    fn open(&self, directory: &str) -> PyResult<PyTable> {
        let table = SweepTable::open(&self.sweep, &self.columns, Path::new(directory));
        let table = Some(table.map_err(unsaved)?);
        Ok(PyTable { table })
    }

    /// Makes these runs in threads; `each` gets the rows as they are finished, in any order.
    fn run(
        &self,
        py: Python<'_>,
        runs: Vec<usize>,
        workers: usize,
        each: Py<PyAny>,
    ) -> PyResult<()> {
        let made = Mutex::new(Vec::new());
        let lock = || made.lock().unwrap_or_else(PoisonError::into_inner);
        let mut give = || {
            let rows: Vec<Row> = lock().drain(..).map(to_python).collect();
            match rows.is_empty() {
                true => Ok(0.0),
                false => Python::attach(|py| each.call1(py, (rows,)).map(|_| 0.0)),
            }
        };
        let mut watch = Watch::new(None);
        py.detach(|| {
            let registry = Registry::standard();
            let worked = watched(&mut watch, &mut give, |flow| {
                let mut add = |row| {
                    lock().push(row);
                    ControlFlow::Continue(())
                };
                self.sweep.run(&registry, &runs, workers, &mut add, flow)
            })?;
            worked.map_err(refused)
        })
    }
}

/// The rows of a sweep in a directory, as `pullback sweep` writes them.
#[pyclass(module = "pullback", name = "SavedTable")]
pub(super) struct PyTable {
    /// None when it is finished.
    table: Option<SweepTable>,
}

#[pymethods]
impl PyTable {
    /// The rows so far.
    fn rows(&self) -> Vec<Row> {
        let rows = self.table.iter().flat_map(SweepTable::rows);
        rows.cloned().map(to_python).collect()
    }

    fn add(&mut self, rows: Vec<Row>) -> PyResult<()> {
        let table = self.table.as_mut();
        let table = table.ok_or_else(|| failed("the table is finished"))?;
        let mut rows = rows.into_iter().map(of_python);
        rows.try_for_each(|row| table.add(row)).map_err(unsaved)
    }

    /// Writes all rows in the order of the runs.
    fn finish(&mut self) -> PyResult<()> {
        match self.table.take() {
            Some(table) => table.finish().map(drop).map_err(unsaved),
            None => Ok(()),
        }
    }
}
