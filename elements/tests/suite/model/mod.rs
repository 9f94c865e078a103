//! Assembled models.

mod allocation;
mod bodies;
mod builder;
mod charts;
mod charts_rows;
mod omitted;
mod refusals;
mod tangent;
mod weights;
