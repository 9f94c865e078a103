//! Springs and dampers: along a line, on one coordinate, and bushings between two frames.

#![allow(non_snake_case)]

mod axial;
mod bushing;
mod coordinate;
mod relative;

pub use axial::AxialSpring;
pub use bushing::Bushing;
pub use coordinate::{CoordinateLaw, CoordinateSpring};

/// Error of a spring.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SpringError {
    /// A number is infinite or not a number.
    #[error("{quantity} must be finite, got {value}")]
    NotFinite {
        /// Name of the quantity.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// A negative number.
    #[error("{quantity} must be zero or positive, got {value}")]
    Negative {
        /// Name of the quantity.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// Neither stiffness nor damping.
    #[error("a spring needs stiffness or damping, both are zero")]
    Nothing,
    /// The two ends of an axial spring have the same reference position.
    #[error("the ends of a spring along a line must be apart, both are at {at:?}")]
    Coincide {
        /// The position.
        at: [f64; 3],
    },
    /// A 6×6 matrix is not symmetric.
    #[error(
        "{quantity} must be symmetric, but entries ({row}, {column}) and ({column}, {row}) are \
         {upper} and {lower}"
    )]
    NotSymmetric {
        /// Name of the matrix.
        quantity: &'static str,
        /// Row, from 1.
        row: usize,
        /// Column, from 1.
        column: usize,
        /// Entry (row, column).
        upper: f64,
        /// Entry (column, row).
        lower: f64,
    },
    /// A 6×6 matrix has negative eigenvalues.
    #[error("{quantity} must be positive semidefinite; the diagonal is {diagonal:?}")]
    NotPositiveSemidefinite {
        /// Name of the matrix.
        quantity: &'static str,
        /// Its diagonal.
        diagonal: [f64; 6],
    },
    /// The axes of a bushing are not a rotation.
    #[error("the axes of a bushing must be the columns of a rotation, got {columns:?}")]
    Axes {
        /// The given axes, column by column.
        columns: [[f64; 3]; 3],
    },
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
