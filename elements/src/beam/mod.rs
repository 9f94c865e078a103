//! Reissner's geometrically exact beam with total rotation vectors (\[M04\] chapter 3).

mod element;
mod mass;
mod orientation;
mod section;
pub(crate) mod shape;
mod strain;
mod viscous;

pub use element::{Beam, BeamError};
pub(crate) use orientation::oriented;
pub use section::{Damping, Material, Section, SectionError, rectangle_torsion};
