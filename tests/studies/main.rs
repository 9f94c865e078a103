//! Computations of minutes that the suite makes small ones of: `cargo test --release --test studies`.

mod andrews;
mod arms;
mod formulations;
mod gallery;
mod heavy_top;
mod mechanisms;
mod rods;
#[allow(dead_code, unused_imports, reason = "the suite uses all of it")]
mod support;
