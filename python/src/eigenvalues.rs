//! Modes, critical loads and Campbell diagrams as dictionaries of arrays.

use super::array;
use pullback::integrators::linearization::Mode;
use pullback::modes::{Eigenvalues, ModelMode, ModelModes};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// What is found at the end of an analysis.
pub(super) fn eigenvalues<'py>(
    py: Python<'py>,
    found: &Eigenvalues,
) -> PyResult<Bound<'py, PyDict>> {
    match found {
        Eigenvalues::Modes(found) => modal(py, found),
        Eigenvalues::Critical(found) => {
            let out = PyDict::new(py);
            let loads = found.modes.iter().map(|mode| mode.load).collect();
            out.set_item("loads", array(py, loads))?;
            out.set_item("coordinates", &found.names)?;
            let shapes = found.modes.iter().map(|mode| array(py, mode.shape.clone()));
            out.set_item("shapes", shapes.collect::<Vec<_>>())?;
            Ok(out)
        }
        Eigenvalues::Campbell(found) => {
            let out = PyDict::new(py);
            let diagram = &found.diagram;
            out.set_item("speeds", array(py, diagram.speeds.clone()))?;
            out.set_item("multi_blade", diagram.multi_blade)?;
            for (name, value) in [
                ("frequencies", (|mode| mode.frequency()) as fn(&Mode) -> f64),
                ("damping_ratios", |mode| mode.damping_ratio()),
            ] {
                let lines = diagram.lines.iter().map(|line| {
                    let values = line
                        .iter()
                        .map(|mode| mode.as_ref().map_or(f64::NAN, value));
                    array(py, values.collect())
                });
                out.set_item(name, lines.collect::<Vec<_>>())?;
            }
            Ok(out)
        }
    }
}

/// Modes about a state.
pub(super) fn modal<'py>(py: Python<'py>, found: &ModelModes) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let each =
        |value: &dyn Fn(&ModelMode) -> f64| array(py, found.modes.iter().map(value).collect());
    out.set_item("frequencies", each(&|m| m.mode.frequency()))?;
    out.set_item("damping_ratios", each(&|m| m.mode.damping_ratio()))?;
    out.set_item("re", each(&|m| m.mode.eigenvalue.re))?;
    out.set_item("im", each(&|m| m.mode.eigenvalue.im))?;
    for (k, name) in ["mass_x", "mass_y", "mass_z"].iter().enumerate() {
        out.set_item(name, each(&|m| m.effective_mass()[k]))?;
    }
    let shape = |part: fn(&ModelMode, usize) -> f64| {
        let shapes = found.modes.iter();
        shapes
            .map(|m| array(py, (0..m.mode.shape.len()).map(|i| part(m, i)).collect()))
            .collect::<Vec<_>>()
    };
    out.set_item("shapes_re", shape(|m, i| m.mode.shape[i].re))?;
    out.set_item("shapes_im", shape(|m, i| m.mode.shape[i].im))?;
    out.set_item("coordinates", &found.names)?;
    out.set_item("counted", found.counted)?;
    out.set_item("warnings", &found.warnings)?;
    Ok(out)
}
