//! Derivatives of maps and pull-backs through them.

mod graph;
mod jets;
mod phase;
mod pose;
mod pullback;
