//! Solvers for systems of `pullback-manifold`: statics and the linear algebra under them.

pub mod linear_solver;
pub mod statics;
