//! Set-up that the suite has too.

#[path = "../suite/support/drawings.rs"]
pub mod drawings;
#[path = "../suite/support/dynamics.rs"]
pub mod dynamics;
#[path = "../suite/support/formulations.rs"]
pub mod formulations;
#[path = "../suite/support/gallery.rs"]
pub mod gallery;
#[path = "../suite/support/heavy_top.rs"]
pub mod heavy_top;
#[path = "../suite/support/independent.rs"]
pub mod independent;
#[path = "../suite/support/loops/mod.rs"]
pub mod loops;
#[path = "../suite/support/prelude.rs"]
pub mod prelude;
#[path = "../suite/support/program.rs"]
pub mod program;

/// Value at no cell size from those of order two with some size and its half.
pub fn extrapolated<const N: usize>(coarse: [f64; N], fine: [f64; N]) -> [f64; N] {
    std::array::from_fn(|k| fine[k] + (fine[k] - coarse[k]) / 3.0)
}
