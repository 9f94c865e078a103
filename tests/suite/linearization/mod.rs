//! Linearised equations of motion and their modes.

mod beams;
mod buckling;
mod linkages;
mod rotating;
