#![doc = include_str!("../README.md")]
//!
//! # Contents
//! - [`System`](pullback_manifold::system::System), in `pullback-manifold`: what is solved.
//! - [`statics`]: load stepping that halves and grows its steps, and path following through limit
//!   points with located events.
//! - [`dynamics`]: Newmark, HHT, WBZ and generalised-α, composite, Runge-Kutta and explicit schemes
//!   by one step routine; steps end at kinks, are halved after a failure, and may follow an error
//!   estimate.
//! - [`spectrum`]: numerical damping and dispersion of schemes, measured and in closed form.
//! - [`linearization`]: K, C and M about a state, and their modes.
//! - [`linear_solver`]: block elimination on the node graph with sparse LU and LDLᵀ behind it.

#![warn(clippy::unwrap_used)]

mod abilities;
mod convergence;
pub mod dynamics;
mod failure;
pub mod linear_solver;
pub mod linearization;
mod random;
mod registers;
mod rounding;
pub mod spectrum;
pub mod statics;
mod vectors;

pub use failure::significant;
