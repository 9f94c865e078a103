//! Springs and dampers: along a line, on one coordinate, and bushings between two frames.

mod axial;
mod bushing;
mod coordinate;
mod relative;

pub use axial::AxialSpring;
pub use bushing::Bushing;
pub use coordinate::{CoordinateLaw, CoordinateSpring};

use crate::Asymmetry;

/// Error of a spring.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "each message says what its variant is")]
#[non_exhaustive]
pub enum SpringError {
    #[error("{quantity} must be finite, got {value}")]
    NotFinite { quantity: &'static str, value: f64 },
    #[error("{quantity} must be zero or positive, got {value}")]
    Negative { quantity: &'static str, value: f64 },
    #[error("a spring needs stiffness or damping, both are zero")]
    Nothing,
    #[error("the ends of a spring along a line must be apart, both are at {at:?}")]
    Coincide { at: [f64; 3] },
    #[error("{quantity} must be symmetric, but {asymmetry}")]
    NotSymmetric {
        quantity: &'static str,
        asymmetry: Asymmetry,
    },
    #[error("{quantity} must be positive semidefinite; the diagonal is {diagonal:?}")]
    NotPositiveSemidefinite {
        quantity: &'static str,
        diagonal: [f64; 6],
    },
    #[error("the axes of a bushing must be the columns of a rotation, got {columns:?}")]
    Axes { columns: [[f64; 3]; 3] },
}

fn finite(quantity: &'static str, values: &[f64]) -> Result<(), SpringError> {
    match values.iter().find(|x| !x.is_finite()) {
        Some(&value) => Err(SpringError::NotFinite { quantity, value }),
        None => Ok(()),
    }
}

fn not_negative(quantity: &'static str, value: f64) -> Result<(), SpringError> {
    finite(quantity, &[value])?;
    if value < 0.0 {
        return Err(SpringError::Negative { quantity, value });
    }
    Ok(())
}
