//! Number of negative eigenvalues of a symmetric matrix, from its factors.
//!
//! By Sylvester's law of inertia a congruence keeps the signs of the eigenvalues, and symmetric
//! elimination by blocks is one: A = L diag(D₁, D₂, ...) Lᵀ has as many negative eigenvalues as
//! the Dₖ together. The pivots of a Dₖ that was factorised without interchanges have the signs
//! themselves. Interchanged rows are no congruence (their pivots only know the sign of the
//! determinant): such a block is multiplied out, and its eigenvalues are computed.

use super::factors::Factors;
use nalgebra::{DMatrix, DMatrixView};

impl Factors {
    /// Number of negative eigenvalues of the factorised matrix, which must be symmetric.
    pub fn negative_pivots(&self) -> usize {
        let panels = self.symbolic.panels.iter().zip(&self.swapped);
        let counts = panels.map(|(panel, &swapped)| {
            let n = panel.size;
            let d = DMatrixView::from_slice(&self.factors[panel.start..panel.start + n * n], n, n);
            let is_negative = |x: &&f64| **x < 0.0;
            if swapped {
                let block = multiply_out(d, &self.swaps[panel.first..panel.first + n]);
                let eigenvalues = block.symmetric_eigenvalues();
                eigenvalues.iter().filter(is_negative).count()
            } else {
                d.diagonal().iter().filter(is_negative).count()
            }
        });
        counts.sum()
    }
}

/// The diagonal block D of the factors P D = L U, which have the reciprocals of the pivots on the
/// diagonal of `d`.
fn multiply_out(d: DMatrixView<'_, f64>, swaps: &[u32]) -> DMatrix<f64> {
    let (mut lower, mut upper) = (d.lower_triangle(), d.upper_triangle());
    lower.fill_diagonal(1.0);
    upper.set_diagonal(&d.diagonal().map(f64::recip));
    let mut block = lower * upper;
    for (k, &row) in swaps.iter().enumerate().rev() {
        block.swap_rows(k, row as usize);
    }
    block
}
