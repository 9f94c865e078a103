//! Reissner's geometrically exact beam with total rotation vectors (\[M04\] chapter 3).

mod element;
mod section;
pub(crate) mod shape;
mod strain;

pub use element::{Beam, BeamError};
pub use section::{Material, Section, SectionError, rectangle_torsion};
