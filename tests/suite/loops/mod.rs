//! Loops of joints closed by maps.

mod joints;
mod limits;
mod linkages;
mod many;
mod program;
mod redundant;
mod singular;
