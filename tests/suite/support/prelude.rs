//! Names of the library that most tests use.

pub use nalgebra::{Matrix3, SVector, Vector2, Vector3};
pub use pullback::elements::{beam::*, body::*, joint::*, load::*, model::*, spring::*, time::*};
pub use pullback::input::{self, Job, Plan, assemble_text};
pub use pullback::integrators::{dynamics::*, statics::*};
pub use pullback::manifold::{domain::*, implicit::*, jet::*, map::*, scalar::*, system::*};
pub use pullback::manifold::{so3, so3::Quaternion};
pub use std::f64::consts::{FRAC_PI_2, PI, TAU};
pub use std::ops::ControlFlow;
