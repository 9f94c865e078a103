//! Bodies: mass attached to a frame node (\[M04\] chapter 3, without the integral).

mod point_mass;
mod rigid;

pub use point_mass::PointMass;
pub use rigid::RigidBody;

/// Error of a body.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BodyError {
    /// A number is infinite or not a number.
    #[error("{quantity} must be finite, got {value}")]
    NotFinite {
        /// Name of the quantity.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// The mass is negative, or that of a point mass is zero.
    #[error("the mass must be {required}, got {mass}")]
    Mass {
        /// The requirement.
        required: &'static str,
        /// The value.
        mass: f64,
    },
    /// The inertia is not symmetric.
    #[error(
        "the inertia must be symmetric, but entries ({row}, {column}) and ({column}, {row}) are \
         {upper} and {lower}"
    )]
    NotSymmetric {
        /// Row, from 1.
        row: usize,
        /// Column, from 1.
        column: usize,
        /// Entry (row, column).
        upper: f64,
        /// Entry (column, row).
        lower: f64,
    },
    /// A principal moment of inertia is negative.
    #[error(
        "the inertia must be positive semidefinite, but its principal moments are {principal:?}"
    )]
    NegativeInertia {
        /// Principal moments of inertia, increasing.
        principal: [f64; 3],
    },
    /// No distribution of mass can have this inertia.
    #[error(
        "no body has the principal moments of inertia {principal:?}: the largest exceeds the sum \
         of the others"
    )]
    Triangle {
        /// Principal moments of inertia, increasing.
        principal: [f64; 3],
    },
    /// Neither mass nor inertia.
    #[error("a body needs mass or inertia, both are zero")]
    Massless,
}
