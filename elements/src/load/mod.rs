//! Loads: elements whose residual is an applied force, with their exact tangents.

mod distributed;
mod nodal;

pub use distributed::LineLoad;
pub use nodal::{NodalLoad, Which};
