//! A model with one state of it, and buffers.

use super::state::ModelState;
use super::{Model, Node};
use crate::model::assembly::workspace::Workspace;
use crate::time::Input;
use pullback_manifold::map::Parametrization;
use std::ops::Deref;
use std::sync::Arc;

/// A [`Model`] with one [`ModelState`] of it, and buffers: what is evaluated and integrated.
///
/// It is a [`System`](pullback_manifold::system::System) for integrators, and answers questions
/// about the configuration last evaluated or set. All methods of the model are available.
/// Contexts share their model: each thread has one of its own. A clone continues independently.
#[derive(Clone)]
pub struct Context {
    pub(super) model: Arc<Model>,
    pub(super) state: ModelState,
    pub(super) work: Workspace,
}

impl Context {
    /// A context at the start of a model.
    pub fn new(model: impl Into<Arc<Model>>) -> Self {
        let model = model.into();
        Self {
            state: model.start.clone(),
            work: model.work.clone(),
            model,
        }
    }

    /// The model.
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// The present state.
    pub fn state(&self) -> &ModelState {
        &self.state
    }

    /// Continues from a state of the same model; false, without a change, for that of another one.
    #[must_use]
    pub fn set_state(&mut self, state: ModelState) -> bool {
        let same = Arc::ptr_eq(&state.model, &self.state.model);
        if same {
            self.state = state;
            self.forget();
        }
        same
    }

    /// The present value of an input.
    ///
    /// # Panics
    /// For an input of another model, if this one has fewer.
    pub fn input(&self, input: Input) -> f64 {
        self.state.inputs[input.0]
    }

    /// Sets the value of an input, from the present step on.
    ///
    /// # Panics
    /// For an input of another model, if this one has fewer.
    pub fn set_input(&mut self, input: Input, value: f64) {
        self.state.inputs[input.0] = value;
    }

    /// Brings all that follows from the state up to date after a change from outside.
    pub(super) fn forget(&mut self) {
        self.work.known.forget();
        self.locate_tangents();
    }

    /// The map of a node in its present chart; `None` if its coordinates are coordinates of the
    /// model.
    pub fn map_of(&self, node: &Node) -> Option<&dyn Parametrization> {
        node.mapped().map(|d| &*self.state.maps[d.index])
    }
}

impl Deref for Context {
    type Target = Model;

    fn deref(&self) -> &Model {
        &self.model
    }
}
