//! Equilibria and paths.

mod equilibrium;
mod newton_damping;
