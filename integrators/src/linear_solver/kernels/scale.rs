//! Scaled copies of blocks.

use super::{by_size, columns, columns_mut};

/// `out ← R B C` for the scales of rows and columns; returns the sum of squares.
pub(in crate::linear_solver) fn scale(
    m: usize,
    n: usize,
    block: &[f64],
    rows: &[f64],
    columns: &[f64],
    out: &mut [f64],
) -> f64 {
    by_size!(m, n, scale_fixed, scale_any, (block, rows, columns, out))
}

fn scale_fixed<const M: usize, const N: usize>(
    block: &[f64],
    rows: &[f64],
    scales: &[f64],
    out: &mut [f64],
) -> f64 {
    let (Some(block), Some(rows), Some(scales), Some(out)) = (
        columns::<M, N>(block),
        rows.first_chunk::<M>(),
        scales.first_chunk::<N>(),
        columns_mut::<M, N>(out),
    ) else {
        return f64::NAN;
    };
    let mut sum = [0.0; M];
    for c in 0..N {
        for r in 0..M {
            let value = block[c][r] * rows[r] * scales[c];
            out[c][r] = value;
            sum[r] += value * value;
        }
    }
    sum.iter().sum()
}

fn scale_any(
    m: usize,
    n: usize,
    block: &[f64],
    rows: &[f64],
    columns: &[f64],
    out: &mut [f64],
) -> f64 {
    let mut sum = 0.0;
    for ((out, block), &c) in out
        .chunks_exact_mut(m)
        .zip(block.chunks_exact(m))
        .zip(columns)
        .take(n)
    {
        for ((out, &value), &r) in out.iter_mut().zip(block).zip(rows) {
            let value = value * r * c;
            *out = value;
            sum += value * value;
        }
    }
    sum
}

/// `out ← (C B R)ᵀ`, `B` n × m, `out` m × n; returns the sum of squares.
pub(in crate::linear_solver) fn scale_transposed(
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
        scale_transposed_fixed,
        scale_transposed_any,
        (block, rows, columns, out)
    )
}

fn scale_transposed_fixed<const M: usize, const N: usize>(
    block: &[f64],
    rows: &[f64],
    scales: &[f64],
    out: &mut [f64],
) -> f64 {
    let (Some(block), Some(rows), Some(scales), Some(out)) = (
        columns::<N, M>(block),
        rows.first_chunk::<M>(),
        scales.first_chunk::<N>(),
        columns_mut::<M, N>(out),
    ) else {
        return f64::NAN;
    };
    let mut sum = [0.0; M];
    for c in 0..N {
        for r in 0..M {
            let value = block[r][c] * rows[r] * scales[c];
            out[c][r] = value;
            sum[r] += value * value;
        }
    }
    sum.iter().sum()
}

fn scale_transposed_any(
    m: usize,
    n: usize,
    block: &[f64],
    rows: &[f64],
    columns: &[f64],
    out: &mut [f64],
) -> f64 {
    let mut sum = 0.0;
    for (c, (out, scale)) in out.chunks_exact_mut(m).zip(columns).take(n).enumerate() {
        for (r, (out, row)) in out.iter_mut().zip(rows).enumerate() {
            let value = block[c + n * r] * row * scale;
            *out = value;
            sum += value * value;
        }
    }
    sum
}
