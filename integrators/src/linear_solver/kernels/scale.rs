//! Scaled copies of blocks.

use super::{by_size, columns_mut};

/// `out ← R B C` for the scales of rows and columns, or if transposed `out ← (C B R)ᵀ` with `B` n × m
/// and `out` m × n; returns the sum of squares.
pub(in crate::linear_solver) fn scale<const TRANSPOSED: bool>(
    m: usize,
    n: usize,
    block: &[f64],
    rows: &[f64],
    columns: &[f64],
    out: &mut [f64],
) -> f64 {
    by_size!(
        m,
        n,
        scale_fixed,
        scale_any,
        (TRANSPOSED, block, rows, columns, out)
    )
}

#[inline(always)]
fn scale_fixed<const M: usize, const N: usize>(
    transposed: bool,
    block: &[f64],
    rows: &[f64],
    scales: &[f64],
    out: &mut [f64],
) -> f64 {
    let (Some(block), Some(rows), Some(scales), Some(out)) = (
        block.get(..M * N),
        rows.first_chunk::<M>(),
        scales.first_chunk::<N>(),
        columns_mut::<M, N>(out),
    ) else {
        return f64::NAN;
    };
    let mut sum = [0.0; M];
    for c in 0..N {
        for r in 0..M {
            let entry = if transposed { c + N * r } else { r + M * c };
            let value = block[entry] * rows[r] * scales[c];
            out[c][r] = value;
            sum[r] += value * value;
        }
    }
    sum.iter().sum()
}

#[inline(always)]
fn scale_any(
    m: usize,
    n: usize,
    transposed: bool,
    block: &[f64],
    rows: &[f64],
    columns: &[f64],
    out: &mut [f64],
) -> f64 {
    let mut sum = 0.0;
    for (c, (out, scale)) in out.chunks_exact_mut(m).zip(columns).take(n).enumerate() {
        for (r, (out, row)) in out.iter_mut().zip(rows).enumerate() {
            let entry = if transposed { c + n * r } else { r + m * c };
            let value = block[entry] * row * scale;
            *out = value;
            sum += value * value;
        }
    }
    sum
}
