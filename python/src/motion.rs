//! Motions step by step.

use super::{ModelError, array, assemble, failed};
use numpy::{PyArray1, PyArrayMethods};
use pullback::motion::{Motion, MotionError, SavedMotion};
use pyo3::exceptions::{PyKeyError, PyUserWarning, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ffi::CString;
use std::sync::{Mutex, PoisonError};

/// A motion, step by step.
///
///     sim = pb.Simulation(model)
///     for _ in sim:
///         sim.set_input("torque", -20 * sim.get("angle") - 2 * sim.get("rate"))
///
/// It begins at the start of a model; ModelError for one without [analysis.dynamic]. Warnings about it are Python warnings.
#[pyclass(name = "Simulation", module = "pullback", subclass)]
pub(super) struct PySimulation {
    motion: Mutex<Motion>,
    /// Text and name of its model.
    model: [String; 2],
}

impl PySimulation {
    fn motion(&mut self) -> &mut Motion {
        self.motion
            .get_mut()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

/// A copy of a motion.
#[pyclass(name = "SavedMotion", module = "pullback", frozen)]
pub(super) struct PySaved {
    motion: SavedMotion,
    model: [String; 2],
}

fn motion_error(error: MotionError) -> PyErr {
    match error {
        MotionError::Unknown { .. } => PyKeyError::new_err(error.to_string()),
        MotionError::Static => ModelError::new_err(error.to_string()),
        error => failed(error),
    }
}

#[pymethods]
impl PySimulation {
    #[new]
    fn new(py: Python<'_>, model: &Bound<'_, PyAny>) -> PyResult<Self> {
        let part = |name| model.getattr(name)?.extract::<String>();
        let model = [part("_text")?, part("_name")?];
        let [text, name] = &model;
        let motion = py.detach(|| Motion::new(assemble(text, name)?).map_err(motion_error))?;
        for warning in motion.warnings() {
            let warning = CString::new(warning.as_str())?;
            PyErr::warn(py, &py.get_type::<PyUserWarning>(), &warning, 1)?;
        }
        let motion = Mutex::new(motion);
        Ok(Self { motion, model })
    }

    /// Makes a step; False at the end. With h the steps from now on are equal, and at most this large.
    ///
    /// AnalysisError if the step fails; the motion is then at the last accepted step.
    #[pyo3(signature = (h=None))]
    fn step(&mut self, py: Python<'_>, h: Option<f64>) -> PyResult<bool> {
        if let Some(h) = h {
            self.motion().set_step(h).map_err(motion_error)?;
        }
        py.detach(|| self.motion().step()).map_err(motion_error)
    }

    fn __iter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __next__(slf: &Bound<'_, Self>) -> PyResult<Option<Py<Self>>> {
        let moved = slf.try_borrow_mut()?.step(slf.py(), None)?;
        Ok(moved.then(|| slf.clone().unbind()))
    }

    /// The present time.
    #[getter]
    fn t(&mut self) -> f64 {
        self.motion().state().t
    }

    /// The coordinates of the model, a copy of shape (n,).
    #[getter]
    fn q<'py>(&mut self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.motion().state().q)
    }

    /// Their velocities, a copy of shape (n,).
    #[getter]
    fn v<'py>(&mut self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.motion().state().v)
    }

    /// Their accelerations, a copy of shape (n,).
    #[getter]
    fn a<'py>(&mut self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.motion().state().a)
    }

    /// The present value of a probe: a number, or an array of shape (3,); KeyError for a name that is none.
    fn get(&mut self, py: Python<'_>, probe: &str) -> PyResult<Py<PyAny>> {
        let values = self.motion().probe(probe).map_err(motion_error)?;
        match values[..] {
            [x] => Ok(x.into_pyobject(py)?.into_any().unbind()),
            _ => Ok(array(py, values).into_any().unbind()),
        }
    }

    /// Sets an input of [inputs], from the next step on; KeyError for a name that is none.
    ///
    /// A coordinate that an input prescribes jumps to its new value with all that is attached to it, without a velocity:
    /// that motion causes no inertia. Move such parts by an actuator, or by a spring to a massless node.
    /// Read values of the present state before: those after it mix new forces with old accelerations.
    fn set_input(&mut self, name: &str, value: f64) -> PyResult<()> {
        match value.is_finite() {
            true => self.motion().set_input(name, value).map_err(motion_error),
            false => Err(PyValueError::new_err(format!(
                "the input {name:?} is {value}"
            ))),
        }
    }

    /// Position and rotation vector of each node, of shape (3,).
    fn poses<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        for (name, [position, rotation]) in self.motion().poses() {
            let pose = [position, rotation].map(|x| PyArray1::from_slice(py, &x).readonly());
            let [position, rotation] = pose;
            out.set_item(name, (&*position, &*rotation))?;
        }
        Ok(out)
    }

    /// A copy of everything that the next step depends on.
    fn save(&mut self) -> PySaved {
        PySaved {
            motion: self.motion().save(),
            model: self.model.clone(),
        }
    }

    /// Goes back to a copy of a motion of the same model; the steps from there are the same to the last bit.
    fn restore(&mut self, saved: &PySaved) -> PyResult<()> {
        if saved.model != self.model {
            let message = "the motion was saved from another model";
            return Err(PyValueError::new_err(message));
        }
        self.motion().restore(&saved.motion).map_err(motion_error)
    }
}
