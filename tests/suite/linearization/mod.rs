//! Linearised equations of motion and their modes.

mod beams;
mod buckling;
mod campbell;
mod flutter;
mod inputs;
mod linkages;
mod rotating;
mod state_space;
