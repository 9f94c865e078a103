//! What changes in a run besides coordinates and time.

use super::{Context, ElementEntry, Model};
use crate::model::charts::element_charts::ElementCharts;
use pullback_manifold::map::Parametrization;
use std::sync::Arc;

/// What changes in a run besides coordinates, velocities and time: inputs, charts, segments and splits
/// of maps, charts of elements, omitted equations.
///
/// A clone is a snapshot: see [`Context::state`](super::Context::state) and
/// [`Context::set_state`](super::Context::set_state).
#[derive(Clone, Default)]
pub struct ModelState {
    /// The same in all states of a model.
    pub(super) model: Arc<()>,
    /// Values of the inputs ([`Input`](crate::time::Input)).
    pub(super) inputs: Vec<f64>,
    /// Maps in their present charts, in the order of [`Model::mapped_nodes`].
    pub(super) maps: Vec<Box<dyn Parametrization>>,
    pub(super) elements: Vec<ElementState>,
    /// Numbers of turns subtracted from prescribed rotations.
    pub(super) turns: Vec<i32>,
    pub(super) element_charts: ElementCharts,
    /// Omitted equations (element, number) that follow from the others only for some prescribed
    /// motions, with the names of these.
    pub(super) overprescribed: Vec<((usize, usize), String)>,
    /// Unknowns at the last choice of omitted equations; empty if there is none.
    pub(super) chosen_at: Vec<f64>,
    /// Whether the omitted equations are not checked.
    pub(super) unwatched: bool,
    /// Initial values with which no loop closes, for reports.
    pub(super) moved: Vec<String>,
}

/// A [`ModelState`] in numbers, for files: what cannot be found from coordinates and time.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SavedState {
    /// Values of the inputs.
    pub inputs: Vec<f64>,
    /// Nodes that each element evaluates through the complement map, bit k for node k.
    pub element_charts: Vec<u32>,
    /// State of the maps between nodes, map by map: reference orientations, branches, segments, splits of
    /// loops and the points from which these are solved. Last, the multiplier equations that are left
    /// out, if any.
    pub maps: Vec<Vec<f64>>,
}

impl Context {
    /// The present state in numbers.
    pub fn save(&self) -> SavedState {
        let state = &self.state;
        let choice = (!state.chosen_at.is_empty()).then(|| self.save_choice());
        SavedState {
            inputs: state.inputs.clone(),
            element_charts: state.elements.iter().map(|e| e.wanted).collect(),
            maps: (state.maps.iter().map(|map| map.save()))
                .chain(choice)
                .collect(),
        }
    }

    /// Continues from [`Context::save`] of the same model; false, without a change, if it belongs to another one.
    #[must_use]
    pub fn restore(&mut self, saved: &SavedState) -> bool {
        let before = self.state.clone();
        let (maps, choice) = saved
            .maps
            .split_at(saved.maps.len().min(self.state.maps.len()));
        // Bit k is the chart of the frame k of an element.
        let fits = |(bits, e): (&u32, &ElementEntry)| {
            let is_frame = |n: &u32| self.model.nodes[*n as usize].is_frame();
            (0..32).all(|k| bits >> k & 1 == 0 || e.nodes.get(k).is_some_and(is_frame))
        };
        let charts = &saved.element_charts;
        let restored = maps.len() == self.state.maps.len()
            && charts.len() == self.model.elements.len()
            && charts.iter().zip(&self.model.elements).all(fits)
            && saved.inputs.len() == self.state.inputs.len()
            && choice.len() == usize::from(!self.state.chosen_at.is_empty())
            && choice.iter().all(|choice| self.restore_choice(choice))
            && (self.state.maps.iter_mut().zip(maps)).all(|(map, saved)| map.restore(saved));
        if restored {
            self.state.inputs.clone_from(&saved.inputs);
            self.set_element_charts(&saved.element_charts);
            // The next change of charts checks the equations that are left out.
            for e in &mut self.state.elements {
                e.violated = None;
            }
        } else {
            self.state = before;
        }
        self.forget();
        restored
    }
}

/// State of an element.
#[derive(Clone, Copy, Default)]
pub(super) struct ElementState {
    /// Bit k: node k is evaluated through the complement map.
    pub switched: u32,
    /// The same in its next chart.
    pub wanted: u32,
    /// Whether the nodes have rotated so far relative to each other that no chart contains them.
    pub overturned: bool,
    /// Equations that follow from others and are omitted: bit i for equation i.
    pub left_out: u32,
    /// An omitted equation that does not follow from the others any more, and its residual.
    pub violated: Option<(usize, f64)>,
}

impl ModelState {
    /// The state of a model as drawn, in the initial charts of its maps.
    pub(super) fn new(model: &Model, inputs: Vec<f64>) -> Self {
        Self {
            inputs,
            maps: model
                .nodes
                .mapped()
                .map(|(_, _, d)| d.map.clone())
                .collect(),
            elements: vec![ElementState::default(); model.elements.len()],
            turns: vec![0; model.prescribed_rotations.len()],
            ..Self::default()
        }
    }
}
