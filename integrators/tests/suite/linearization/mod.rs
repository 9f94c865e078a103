//! Modes of linear systems.

mod chain;
mod requests;
