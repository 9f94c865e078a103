//! Steps and runs in time.

mod error_estimate;
mod explicit;
mod inertia;
mod runs;
mod steps;
