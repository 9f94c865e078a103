//! Motions step by step.

use super::{ModelError, array, assemble, failed};
use numpy::{PyArray1, PyArrayMethods};
use pullback::motion::{Motion, MotionError, SavedMotion};
use pyo3::exceptions::{PyKeyError, PyStopIteration, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Mutex, PoisonError};

/// A motion step by step.
#[pyclass(name = "Motion", module = "pullback._pullback")]
pub(super) struct PyMotion(Mutex<Motion>);

impl PyMotion {
    fn motion(&mut self) -> &mut Motion {
        self.0.get_mut().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A copy of a motion.
#[pyclass(name = "SavedMotion", module = "pullback._pullback", frozen)]
pub(super) struct PySaved(SavedMotion);

fn motion_error(error: MotionError) -> PyErr {
    match error {
        MotionError::Unknown { .. } => PyKeyError::new_err(error.to_string()),
        MotionError::Static => ModelError::new_err(error.to_string()),
        error => failed(error),
    }
}

#[pymethods]
impl PyMotion {
    #[new]
    fn new(py: Python<'_>, text: &str, name: &str) -> PyResult<Self> {
        py.detach(|| Motion::new(assemble(text, name)?).map_err(motion_error))
            .map(|motion| Self(Mutex::new(motion)))
    }

    /// One step; raises StopIteration at the end.
    fn step(&mut self, py: Python<'_>, h: Option<f64>) -> PyResult<()> {
        if let Some(h) = h {
            self.motion().set_step(h).map_err(motion_error)?;
        }
        match py.detach(|| self.motion().step()).map_err(motion_error)? {
            true => Ok(()),
            false => Err(PyStopIteration::new_err("the motion is at its end")),
        }
    }

    fn warnings(&mut self) -> Vec<String> {
        self.motion().warnings().to_vec()
    }

    #[getter]
    fn t(&mut self) -> f64 {
        self.motion().state().t
    }

    #[getter]
    fn q<'py>(&mut self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.motion().state().q)
    }

    #[getter]
    fn v<'py>(&mut self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.motion().state().v)
    }

    #[getter]
    fn a<'py>(&mut self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.motion().state().a)
    }

    fn get(&mut self, py: Python<'_>, probe: &str) -> PyResult<Py<PyAny>> {
        let values = self.motion().probe(probe).map_err(motion_error)?;
        match values[..] {
            [x] => Ok(x.into_pyobject(py)?.into_any().unbind()),
            _ => Ok(array(py, values).into_any().unbind()),
        }
    }

    fn set_input(&mut self, name: &str, value: f64) -> PyResult<()> {
        match value.is_finite() {
            true => self.motion().set_input(name, value).map_err(motion_error),
            false => Err(PyValueError::new_err(format!(
                "the input {name:?} is {value}"
            ))),
        }
    }

    fn poses<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        for (name, [position, rotation]) in self.motion().poses() {
            let pose = [position, rotation].map(|x| PyArray1::from_slice(py, &x).readonly());
            let [position, rotation] = pose;
            out.set_item(name, (&*position, &*rotation))?;
        }
        Ok(out)
    }

    fn save(&mut self) -> PySaved {
        PySaved(self.motion().save())
    }

    fn restore(&mut self, saved: &PySaved) -> PyResult<()> {
        self.motion().restore(&saved.0).map_err(motion_error)
    }
}
