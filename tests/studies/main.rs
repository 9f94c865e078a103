//! Computations of minutes that the suite makes small ones of: `cargo test --release --test studies`.
// The symbols of the equations.

mod andrews;
mod arms;
mod formulations;
mod gallery;
mod heavy_top;
mod mechanisms;
mod rods;
// The suite uses all of it.
#[allow(dead_code)]
mod support;
