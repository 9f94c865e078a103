//! All integration tests of integrators and solvers, linked once.
#![allow(non_snake_case, reason = "symbols are those of the equations")]

mod dynamics;
mod linear_solver;
mod linearization;
mod schemes;
mod statics;
mod support;
