//! Residual and tangent of all elements in a pattern.

pub(super) mod couplings;
pub(super) mod element_workspace;
pub(super) mod pull_back;
pub(super) mod residual;
pub(super) mod scatter;
pub(super) mod scatter_map;
pub(super) mod workspace;
