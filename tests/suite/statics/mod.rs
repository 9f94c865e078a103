//! Equilibria and their stability.

mod convergence;
mod corrections;
mod critical;
mod energies;
mod equilibrium;
mod program;
mod stability;
mod units;
