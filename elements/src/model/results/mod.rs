//! Questions about a model and its configuration.

pub(super) mod cyclic_symmetry;
pub(super) mod energies;
pub(super) mod forces;
pub(super) mod mobility;
pub(super) mod query;
pub(super) mod symmetry;
pub(super) mod view;
