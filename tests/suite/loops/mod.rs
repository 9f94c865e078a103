//! Loops of joints closed by maps.

mod limits;
mod many;
mod program;
mod redundant;
mod reparametrized;
mod singular;
