//! Equilibria and their stability.

mod convergence;
mod corrections;
mod energies;
mod equilibrium;
mod program;
mod stability;
mod units;
