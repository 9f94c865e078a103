//! Linear solvers, each on the same systems.

mod allocation;
mod fallback;
mod inertia;
mod residuals;
mod singular;
mod solutions;
