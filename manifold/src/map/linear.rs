//! Coordinates that follow from others by a constant matrix: a selection, a gear.

use super::Map;
use crate::scalar::Scalar;
use nalgebra::{SMatrix, SVector};

/// x = A q + b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear<const D: usize, const N: usize> {
    /// A, N×D.
    pub A: SMatrix<f64, N, D>,
    /// b.
    pub b: SVector<f64, N>,
}

impl<const D: usize> Linear<D, 1> {
    /// Coordinate `k` of D, less `origin`: x = q_k − origin. Zero if there is no such coordinate.
    pub fn pick(k: usize, origin: f64) -> Self {
        Self {
            A: SMatrix::from_fn(|_, j| f64::from(j == k)),
            b: SVector::repeat(-origin),
        }
    }

    /// The sum of coordinates with these factors: a gear or a rack with one, or an absolute angle as the
    /// sum of relative ones.
    pub fn sum(factors: [f64; D], offset: f64) -> Self {
        Self {
            A: SMatrix::from_fn(|_, j| factors[j]),
            b: SVector::repeat(offset),
        }
    }
}

impl<const D: usize, const N: usize> Map<D, N> for Linear<D, N> {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, D>) -> SVector<S, N> {
        SVector::from_fn(|i, _| {
            let mut x = S::constant(self.b[i]);
            for j in (0..D).filter(|&j| self.A[(i, j)] != 0.0) {
                x += q[j] * self.A[(i, j)];
            }
            x
        })
    }
}
