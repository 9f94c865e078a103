//! A model with one state of it, and buffers.

use super::state::State;
use super::{Model, Node, Source};
use crate::model::assembly::workspace::Workspace;
use pullback_manifold::map::Parametrization;
use std::ops::Deref;
use std::sync::Arc;

/// A [`Model`] with one [`State`] of it, and buffers: what is evaluated and integrated.
///
/// It is a [`System`](pullback_manifold::system::System) for integrators, and answers questions
/// about the configuration last evaluated or set. All methods of the model are available.
/// Contexts share their model: each thread has one of its own. A clone continues independently,
/// except for [`Input`](crate::time::Input)s, which belong to the model.
#[derive(Clone)]
pub struct Context {
    pub(super) model: Arc<Model>,
    pub(super) state: State,
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
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Continues from a state of the same model; false, without a change, for that of another one.
    #[must_use]
    pub fn set_state(&mut self, state: State) -> bool {
        let same = Arc::ptr_eq(&state.model, &self.state.model);
        if same {
            self.state = state;
            self.forget();
        }
        same
    }

    /// Brings all that follows from the state up to date after a change from outside.
    pub(super) fn forget(&mut self) {
        self.work.dead_loads.forget();
        self.work.forget_motions();
        self.locate_tangents();
    }

    /// The map of a node in its present chart; `None` if its coordinates are coordinates of the
    /// model.
    pub fn map_of(&self, node: &Node) -> Option<&dyn Parametrization> {
        match &node.source {
            Source::Own => None,
            Source::Mapped(d) => Some(&*self.state.maps[d.index]),
        }
    }
}

impl Deref for Context {
    type Target = Model;

    fn deref(&self) -> &Model {
        &self.model
    }
}
