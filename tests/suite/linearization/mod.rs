//! Linearised equations of motion and their modes.

mod beams;
mod linkages;
mod rotating;
