//! Building a model: nodes, elements, supports, numbering.

pub(super) mod axis;
pub(super) mod builder;
pub(super) mod closures;
pub(super) mod connections;
pub(super) mod dependency_graph;
pub(super) mod dummy_dof;
pub(super) mod line;
pub(super) mod numbering;
