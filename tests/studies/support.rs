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
#[path = "../suite/support/program.rs"]
pub mod program;
