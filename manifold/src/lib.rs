//! Manifolds, charts and maps: the mathematics under `pullback`.

pub mod jet;
pub mod scalar;
pub mod sparse;
