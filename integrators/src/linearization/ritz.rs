//! Eigenvalues of the small dense matrices of Krylov subspaces, by faer.

#![allow(non_snake_case)]

use faer::{Mat, Side};
use num_complex::Complex64;

/// An approximate eigenvalue of an operator, and its eigenvector in a basis.
pub(crate) struct RitzPair {
    /// The eigenvalue.
    pub theta: Complex64,
    /// Coefficients of the eigenvector, of length one.
    pub vector: Vec<Complex64>,
    /// Length of A x − θ x.
    pub residual: f64,
}

/// Eigenvalues of the upper square of the matrix with these columns, the largest magnitude first; the rows
/// below give the residuals. `None` if the iteration fails.
pub(super) fn ritz_pairs(columns: &[Vec<f64>], symmetric: bool) -> Option<Vec<RitzPair>> {
    let n = columns.len();
    let entry = |i: usize, j: usize| columns[j].get(i).copied().unwrap_or(0.0);
    if !(0..n).all(|j| columns[j].iter().all(|x| x.is_finite())) {
        return None;
    }
    let mut pairs: Vec<(Complex64, Vec<Complex64>)> = if symmetric {
        let H = Mat::from_fn(n, n, |i, j| 0.5 * (entry(i, j) + entry(j, i)));
        let pairs = H.self_adjoint_eigen(Side::Lower).ok()?;
        let vector = |k: usize| (0..n).map(|i| pairs.U()[(i, k)].into()).collect();
        (0..n).map(|k| (pairs.S()[k].into(), vector(k))).collect()
    } else {
        let pairs = Mat::from_fn(n, n, entry).eigen().ok()?;
        let vector = |k: usize| {
            let column = (0..n).map(|i| pairs.U()[(i, k)]);
            let length = column.clone().map(|x| x.norm_sqr()).sum::<f64>().sqrt();
            column.map(|x| x / length).collect()
        };
        (0..n).map(|k| (pairs.S()[k], vector(k))).collect()
    };
    pairs.sort_by(|a, b| b.0.norm().total_cmp(&a.0.norm()));
    let height = columns.iter().map(Vec::len).max().unwrap_or(0);
    let residual = |s: &[Complex64]| {
        let row = |i: usize| s.iter().enumerate().map(move |(j, s)| *s * entry(i, j));
        let squares = (n..height).map(|i| row(i).sum::<Complex64>().norm_sqr());
        squares.sum::<f64>().sqrt()
    };
    let pairs = pairs.into_iter().map(|(theta, vector)| RitzPair {
        theta,
        residual: residual(&vector),
        vector,
    });
    Some(pairs.collect())
}
