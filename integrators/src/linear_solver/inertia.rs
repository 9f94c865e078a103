//! Number of negative eigenvalues of a symmetric matrix, from its factors.
//!
//! By Sylvester's law of inertia a congruence keeps the signs of the eigenvalues, and symmetric
//! elimination by blocks is one: A = L diag(D₁, D₂, ...) Lᵀ has as many negative eigenvalues as
//! the Dₖ together. The pivots of a Dₖ that was factorised without interchanges have the signs
//! themselves. Interchanged rows are no congruence (their pivots only know the sign of the
//! determinant): such a block is multiplied out and eliminated symmetrically.

use super::factors::Factors;

impl Factors {
    /// Number of negative eigenvalues of the factorised matrix, which must be symmetric.
    pub fn negative_pivots(&self) -> usize {
        let mut count = 0;
        let mut block = Vec::new();
        for (panel, &swapped) in self.symbolic.panels.iter().zip(&self.swapped) {
            let n = panel.size;
            let d = &self.factors[panel.start..panel.start + n * n];
            if swapped {
                let swaps = &self.swaps[panel.first..panel.first + n];
                multiply_out(n, d, swaps, &mut block);
                count += negative_eigenvalues(n, &mut block);
            } else {
                count += (0..n).filter(|k| d[k * (n + 1)] < 0.0).count();
            }
        }
        count
    }
}

/// The diagonal block D of the factors P D = L U, which have the reciprocals of the pivots on the
/// diagonal of `d`; into `block`, column by column.
fn multiply_out(n: usize, d: &[f64], swaps: &[u32], block: &mut Vec<f64>) {
    block.clear();
    for c in 0..n {
        for r in 0..n {
            let sum: f64 = (0..r.min(c + 1))
                .map(|k| d[k * n + r] * upper(n, d, k, c))
                .sum();
            let own = if r <= c { upper(n, d, r, c) } else { 0.0 };
            block.push(sum + own);
        }
    }
    for (k, &row) in swaps.iter().enumerate().rev() {
        for column in block.chunks_exact_mut(n) {
            column.swap(k, row as usize);
        }
    }
}

/// Entry of the upper factor.
fn upper(n: usize, d: &[f64], row: usize, column: usize) -> f64 {
    let entry = d[column * n + row];
    if row == column { 1.0 / entry } else { entry }
}

/// Ratio to the largest entry above which a diagonal entry is a pivot; below, a pair of rows is.
const DIAGONAL: f64 = 0.640_388_203_202_208;

/// Negative eigenvalues of a small symmetric matrix, which is destroyed: elimination with complete
/// symmetric pivoting (Bunch & Parlett 1971). A pair of rows is a pivot whose diagonal is small
/// beside what couples the two: one of its eigenvalues is negative, the other one positive.
fn negative_eigenvalues(n: usize, a: &mut [f64]) -> usize {
    let mut count = 0;
    let mut left: Vec<usize> = (0..n).collect();
    while !left.is_empty() {
        let size = |r: usize, c: usize| a[c * n + r].abs();
        let (mut i, mut pair) = (0, (0, 0));
        for r in 0..left.len() {
            if size(left[r], left[r]) > size(left[i], left[i]) {
                i = r;
            }
            for c in 0..r {
                if pair.0 == pair.1 || size(left[r], left[c]) > size(left[pair.0], left[pair.1]) {
                    pair = (r, c);
                }
            }
        }
        let coupled = if pair.0 == pair.1 {
            0.0
        } else {
            size(left[pair.0], left[pair.1])
        };
        if size(left[i], left[i]) >= DIAGONAL * coupled {
            let p = left.swap_remove(i);
            let pivot = a[p * n + p];
            count += usize::from(pivot < 0.0);
            if pivot == 0.0 {
                // Nothing is left.
                return count;
            }
            for &c in &left {
                let factor = a[c * n + p] / pivot;
                for &r in &left {
                    a[c * n + r] -= a[p * n + r] * factor;
                }
            }
        } else {
            // The later one goes first, so that the other keeps its index.
            let (p, q) = (left.swap_remove(pair.0), left.swap_remove(pair.1));
            count += 1;
            let (pp, pq, qq) = (a[p * n + p], a[q * n + p], a[q * n + q]);
            let determinant = pp * qq - pq * pq;
            for &c in &left {
                let (x, y) = (a[c * n + p], a[c * n + q]);
                let (u, w) = (
                    (qq * x - pq * y) / determinant,
                    (pp * y - pq * x) / determinant,
                );
                for &r in &left {
                    a[c * n + r] -= a[p * n + r] * u + a[q * n + r] * w;
                }
            }
        }
    }
    count
}
