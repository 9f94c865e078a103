//! Blocks of vectors and of matrices that are stored column by column.

use nalgebra::{SMatrix, SVector, Vector3};

/// Three entries of a slice.
#[inline]
pub(crate) fn three(x: &[f64], at: usize) -> Vector3<f64> {
    Vector3::new(x[at], x[at + 1], x[at + 2])
}

/// Three entries of a slice; zero where it has none, as velocities in statics.
#[inline]
pub(crate) fn three_or_zero(x: &[f64], at: usize) -> Vector3<f64> {
    x.get(at..at + 3)
        .map_or_else(Vector3::zeros, Vector3::from_column_slice)
}

/// Adds a vector to the entries from `first` on.
#[inline]
pub(crate) fn add<const N: usize>(out: &mut [f64], first: usize, x: &SVector<f64, N>) {
    for (o, x) in out[first..first + N].iter_mut().zip(x.iter()) {
        *o += x;
    }
}

/// Adds a block to a matrix of n rows.
#[inline]
pub(crate) fn add_block<const M: usize, const N: usize>(
    out: &mut [f64],
    n: usize,
    row: usize,
    column: usize,
    block: &SMatrix<f64, M, N>,
) {
    for c in 0..N {
        let start = row + (column + c) * n;
        for (o, a) in out[start..start + M].iter_mut().zip(block.column(c).iter()) {
            *o += a;
        }
    }
}
