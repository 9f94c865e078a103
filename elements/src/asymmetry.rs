//! Symmetry of given matrices.

use nalgebra::SMatrix;

/// Two entries of a matrix that must be equal and are not.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("entries ({row}, {column}) and ({column}, {row}) are {upper} and {lower}")]
pub struct Asymmetry {
    /// Row of the upper entry, from 1.
    pub row: usize,
    /// Its column, from 1.
    pub column: usize,
    /// Entry (row, column).
    pub upper: f64,
    /// Entry (column, row).
    pub lower: f64,
}

impl Asymmetry {
    /// The first two entries (i, j) and (j, i), i > j, whose difference exceeds `tolerance(i, j)`.
    pub(crate) fn of<const N: usize>(
        A: &SMatrix<f64, N, N>,
        tolerance: impl Fn(usize, usize) -> f64,
    ) -> Option<Self> {
        let mut pairs = (0..N).flat_map(|i| (0..i).map(move |j| (i, j)));
        let (i, j) = pairs.find(|&(i, j)| (A[(i, j)] - A[(j, i)]).abs() > tolerance(i, j))?;
        Some(Self {
            row: j + 1,
            column: i + 1,
            upper: A[(j, i)],
            lower: A[(i, j)],
        })
    }
}
