//! Steps and runs in time.

mod error_estimate;
mod events;
mod explicit;
mod runs;
mod steps;
mod tsitouras;
