//! Manifolds, charts and maps: the mathematics under `pullback`.

pub mod chart;
pub mod check;
pub mod jet;
pub mod map;
pub mod pullback;
pub mod quotients;
pub mod scalar;
pub mod so3;
pub mod sparse;
pub mod system;
