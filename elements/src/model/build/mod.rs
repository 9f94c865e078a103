//! Building a model: nodes, elements, supports, numbering.

pub(super) mod beam_line;
pub(super) mod builder;
pub(super) mod closures;
pub(super) mod connections;
pub(super) mod dependency_graph;
pub(super) mod dummy_dof;
pub(super) mod elimination_order;
pub(super) mod mapped_nodes;
pub(super) mod numbering;
pub(super) mod prescribed;
pub(super) mod reference_curve;
