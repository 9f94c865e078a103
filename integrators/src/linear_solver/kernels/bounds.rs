//! Row sums of |L||U|, block by block, for bounds on rounding errors.

use super::{by_size, columns};

/// `v ← |U| e` of a factorised diagonal block.
pub(in crate::linear_solver) fn upper_sums(n: usize, d: &[f64], v: &mut [f64]) {
    match n {
        6 => upper_sums_fixed::<6>(d, v),
        _ => {
            for (r, v) in v.iter_mut().enumerate().take(n) {
                let right = (r + 1..n).map(|c| d[c * n + r].abs()).sum::<f64>();
                *v = 1.0 / d[r * (n + 1)].abs() + right;
            }
        }
    }
}

fn upper_sums_fixed<const N: usize>(d: &[f64], v: &mut [f64]) {
    let (Some(d), Some(v)) = (columns::<N, N>(d), v.first_chunk_mut::<N>()) else {
        return;
    };
    let mut sum = [0.0; N];
    for r in 0..N {
        sum[r] = 1.0 / d[r][r].abs();
    }
    for c in 1..N {
        for r in 0..c {
            sum[r] += d[c][r].abs();
        }
    }
    *v = sum;
}

/// `v ← v + |U| e` of a block right of it, `Uᵀ` m × n.
pub(in crate::linear_solver) fn add_sums(m: usize, n: usize, ut: &[f64], v: &mut [f64]) {
    by_size!(m, n, add_sums_fixed, add_sums_any, (ut, v))
}

fn add_sums_fixed<const M: usize, const N: usize>(ut: &[f64], v: &mut [f64]) {
    let (Some(ut), Some(v)) = (columns::<M, N>(ut), v.first_chunk_mut::<N>()) else {
        return;
    };
    let mut sum = *v;
    for r in 0..M {
        for c in 0..N {
            sum[c] += ut[c][r].abs();
        }
    }
    *v = sum;
}

fn add_sums_any(m: usize, n: usize, ut: &[f64], v: &mut [f64]) {
    for (v, column) in v.iter_mut().zip(ut.chunks_exact(m)).take(n) {
        *v += column.iter().map(|u| u.abs()).sum::<f64>();
    }
}

/// Largest entry of `|L| v` of a factorised diagonal block, for nonnegative `v`.
pub(in crate::linear_solver) fn lower_product(n: usize, d: &[f64], v: &[f64]) -> f64 {
    match n {
        6 => lower_product_fixed::<6>(d, v),
        _ => (0..n)
            .map(|r| v[r] + (0..r).map(|c| d[c * n + r].abs() * v[c]).sum::<f64>())
            .fold(0.0, larger),
    }
}

fn lower_product_fixed<const N: usize>(d: &[f64], v: &[f64]) -> f64 {
    let (Some(d), Some(v)) = (columns::<N, N>(d), v.first_chunk::<N>()) else {
        return f64::NAN;
    };
    let mut sum = *v;
    for c in 0..N {
        for r in c + 1..N {
            sum[r] += d[c][r].abs() * v[c];
        }
    }
    sum.into_iter().fold(0.0, larger)
}

/// Largest entry of `|L| v`, `L` m × n, for nonnegative `v`.
pub(in crate::linear_solver) fn product(m: usize, n: usize, l: &[f64], v: &[f64]) -> f64 {
    by_size!(m, n, product_fixed, product_any, (l, v))
}

fn product_fixed<const M: usize, const N: usize>(l: &[f64], v: &[f64]) -> f64 {
    let (Some(l), Some(v)) = (columns::<M, N>(l), v.first_chunk::<N>()) else {
        return f64::NAN;
    };
    let mut sum = [0.0; M];
    for c in 0..N {
        for r in 0..M {
            sum[r] += l[c][r].abs() * v[c];
        }
    }
    sum.into_iter().fold(0.0, larger)
}

fn product_any(m: usize, n: usize, l: &[f64], v: &[f64]) -> f64 {
    (0..m)
        .map(|r| (0..n).map(|c| l[c * m + r].abs() * v[c]).sum::<f64>())
        .fold(0.0, larger)
}

/// The larger of two. A NaN may get lost: it propagates to a later pivot, where it is detected.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
