//! Coordinates, velocities and operators of all nodes.

pub(super) mod complement;
pub(super) mod formulation;
pub(super) mod free_coordinates;
pub(super) mod mapped_node;
pub(super) mod motion;
pub(super) mod node_entries;
pub(super) mod pose;
pub(super) mod rates;
