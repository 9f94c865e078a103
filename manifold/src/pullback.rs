//! The pull-back of a residual and its tangents by a map, for any element and any map (\[M04\]
//! (180), (183)).
//!
//! ```text
//! r_mr = Bᵀ r
//! M_mr = Bᵀ M B
//! C_mr = Bᵀ (C B + 2 M Ḃ)
//! K_mr = Bᵀ (K B + C Ḃ + M B̈) − K_σ(r)
//! ```

use nalgebra::{RowSVector, SMatrix, SVector};

/// Factors of B, Ḃ and B̈ in the columns of K, C and M.
const FACTORS: [[f64; 3]; 3] = [[1.0, 1.0, 1.0], [1.0, 2.0, 0.0], [1.0, 0.0, 0.0]];

/// Overwrites tangents by those pulled back by a map of D of the coordinates to as many others.
///
/// `parts` are K, C and M of n coordinates (n×n, by columns), at rest K alone; the map is one of the coordinates from
/// `first` on, with the operators `B`, Ḃ and B̈, and with `K_sigma` for the residual before its own pull-back.
/// Maps of other coordinates may follow one after the other.
pub fn tangents<const D: usize>(
    parts: &mut [&mut [f64]],
    n: usize,
    first: usize,
    B: &[SMatrix<f64, D, D>; 3],
    K_sigma: &SMatrix<f64, D, D>,
) {
    for order in 0..parts.len() {
        for i in 0..n {
            let mut row = RowSVector::<f64, D>::zeros();
            for (k, part) in parts[order..].iter().enumerate() {
                let given = RowSVector::<f64, D>::from_fn(|_, j| part[i + (first + j) * n]);
                row += given * B[k] * FACTORS[order][k];
            }
            for (j, value) in row.iter().enumerate() {
                parts[order][i + (first + j) * n] = *value;
            }
        }
        for column in parts[order].chunks_exact_mut(n) {
            let own = &mut column[first..first + D];
            let pulled = B[0].tr_mul(&SVector::<f64, D>::from_column_slice(own));
            own.copy_from_slice(pulled.as_slice());
        }
    }
    let Some(K) = parts.first_mut() else { return };
    for (j, column) in K_sigma.column_iter().enumerate() {
        let own = &mut K[first + (first + j) * n..][..D];
        for (K, K_sigma) in own.iter_mut().zip(column.iter()) {
            *K -= K_sigma;
        }
    }
}

/// The entries of Bᵀ f, one after the other; B (n×d) column by column, f with n entries.
pub fn transposed(B: &[f64], f: &[f64]) -> impl Iterator<Item = f64> {
    let columns = B.chunks_exact(f.len().max(1));
    // Most nodes are frames: a sum without a loop.
    let frame = <&[f64; 6]>::try_from(f).ok();
    columns.map(move |B| match (frame, <&[f64; 6]>::try_from(B)) {
        (Some(f), Ok(B)) => B.iter().zip(f).map(|(b, f)| b * f).sum(),
        _ => B.iter().zip(f).map(|(b, f)| b * f).sum(),
    })
}
