//! Residual and tangent of all elements in a pattern.

pub(super) mod couplings;
pub(super) mod element_workspace;
pub(super) mod residual;
mod rigid_link;
pub(super) mod scatter;
pub(super) mod scatter_map;
pub(super) mod workspace;
