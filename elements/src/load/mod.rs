//! Loads: elements whose residual is an applied force, with their exact tangents.

mod coordinate;
mod distributed;
mod eccentric;
mod nodal;

pub use coordinate::CoordinateForce;
pub use distributed::LineLoad;
pub use eccentric::EccentricForce;
pub use nodal::{LoadKind, NodalLoad};
