//! Set-up that several tests share.

pub mod beams;
pub mod closures;
pub mod comparisons;
pub mod drawings;
pub mod dynamics;
pub mod formulations;
pub mod gallery;
pub mod heavy_top;
pub mod included;
pub mod independent;
pub mod laboratory;
pub mod landing;
pub mod loops;
pub mod prelude;
pub mod program;

pub use closures::*;
pub use program::*;
