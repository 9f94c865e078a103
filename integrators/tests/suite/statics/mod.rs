//! Equilibria and paths.

mod critical;
mod equilibrium;
mod newton_damping;
