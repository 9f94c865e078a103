//! Assembled models.

mod allocation;
mod bodies;
mod builder;
mod charts;
mod omitted;
mod refusals;
mod tangent;
mod weights;
