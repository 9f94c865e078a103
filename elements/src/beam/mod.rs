//! Reissner's geometrically exact beam (\[M04\] chapter 3), with total rotation vectors or with a
//! geodesic interpolation of relative rotations.

mod element;
mod geodesic;
mod interpolation;
mod mass;
mod nodal;
mod orientation;
mod point;
pub(crate) mod relative;
mod section;
pub(crate) mod shape;
mod strain;
mod viscous;

pub use element::{Beam, BeamError};
pub use geodesic::Geodesic;
pub use interpolation::{Interpolation, Rotations, Seen, Total};
pub use mass::{MassPoint, carried};
pub use orientation::oriented;
pub use section::{Damping, Material, Section, SectionError, rectangle_torsion};
