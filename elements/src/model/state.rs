//! What changes in a run besides coordinates and time.

use super::{Model, Source};
use crate::model::charts::element_charts::ElementCharts;
use pullback_manifold::map::Parametrization;
use std::sync::Arc;

/// What changes in a run besides coordinates, velocities and time: charts, segments and splits of
/// maps, charts of elements, omitted equations.
///
/// A clone is a snapshot: see [`Context::state`](super::Context::state) and
/// [`Context::set_state`](super::Context::set_state).
#[derive(Clone, Default)]
pub struct State {
    /// The same in all states of a model.
    pub(super) model: Arc<()>,
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

impl State {
    /// The state of a model as drawn, in the initial charts of its maps.
    pub(super) fn new(model: &Model) -> Self {
        let map = |&n: &u32| match &model.nodes[n as usize].source {
            Source::Mapped(d) => Some(d.map.clone()),
            Source::Own => None,
        };
        Self {
            model: Arc::default(),
            maps: model.dependent.iter().filter_map(map).collect(),
            elements: vec![ElementState::default(); model.elements.len()],
            turns: vec![0; model.prescribed_rotations.len()],
            element_charts: ElementCharts::default(),
            overprescribed: Vec::new(),
            chosen_at: Vec::new(),
            unwatched: false,
            moved: Vec::new(),
        }
    }
}
