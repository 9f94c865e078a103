//! Bodies: mass attached to a frame node (\[M04\] chapter 3, without the integral).

mod point_mass;
mod rigid;

pub use point_mass::PointMass;
pub use rigid::RigidBody;

use crate::Asymmetry;

/// Error of a body.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "each message says what its variant is")]
#[non_exhaustive]
pub enum BodyError {
    #[error("{quantity} must be finite, got {value}")]
    NotFinite { quantity: &'static str, value: f64 },
    #[error("the mass must be {required}, got {mass}")]
    Mass { required: &'static str, mass: f64 },
    #[error("the inertia must be symmetric, but {0}")]
    NotSymmetric(Asymmetry),
    #[error(
        "the inertia must be positive semidefinite, but its principal moments are {principal:?}"
    )]
    NegativeInertia {
        /// Principal moments of inertia, increasing.
        principal: [f64; 3],
    },
    #[error(
        "no body has the principal moments of inertia {principal:?}: the largest exceeds the sum \
         of the others"
    )]
    Triangle {
        /// Principal moments of inertia, increasing.
        principal: [f64; 3],
    },
    #[error("a body needs mass or inertia, both are zero")]
    Massless,
}
