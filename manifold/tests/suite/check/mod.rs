//! The check kit: right things pass, planted errors are found.

mod conformance;
mod forces;
mod maps;
