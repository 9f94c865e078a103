//! Elements, loads and models of flexible multibody systems on top of `pullback-manifold`.

pub mod beam;
pub mod check;
pub mod element;
pub mod load;
pub mod model;
pub mod time;
