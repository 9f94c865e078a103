//! All integration tests of integrators and solvers, linked once.

mod dynamics;
mod linear_solver;
mod linearization;
mod schemes;
mod statics;
mod support;
