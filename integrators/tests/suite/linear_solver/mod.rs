//! Linear solvers, each on the same systems.

mod allocation;
mod fallback;
mod singular;
mod solutions;
