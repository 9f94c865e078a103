//! Maps defined by equations.

mod closed;
mod flat;
mod solved;
mod steep;
