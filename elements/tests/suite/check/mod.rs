//! The check kit: right things pass, planted errors are found.

mod joints;
mod model;
mod pieces;
mod planted;
