//! Modes of linear systems.

mod chain;
