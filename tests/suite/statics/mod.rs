//! Equilibria and their stability.

mod convergence;
mod corrections;
mod critical;
mod energies;
mod equilibrium;
mod imperfections;
mod program;
mod stability;
mod units;
