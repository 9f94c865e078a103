//! Formulations of rotations besides the total one.

mod charts;
mod exact;
mod lie_group;
mod page;
mod spin_vectors;
