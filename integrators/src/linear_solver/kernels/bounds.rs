//! Row sums of |L||U|, block by block, for bounds on rounding errors.

use super::by_size;

/// `v ← |U| e` of a factorised diagonal block.
pub(in crate::linear_solver) fn upper_sums(n: usize, d: &[f64], v: &mut [f64]) {
    match n {
        6 => upper_sums_of(6, d, v),
        3 => upper_sums_of(3, d, v),
        _ => upper_sums_of(n, d, v),
    }
}

#[inline(always)]
fn upper_sums_of(n: usize, d: &[f64], v: &mut [f64]) {
    let (d, v) = (&d[..n * n], &mut v[..n]);
    for r in 0..n {
        v[r] = 1.0 / d[r * (n + 1)].abs();
    }
    for c in 1..n {
        for r in 0..c {
            v[r] += d[c * n + r].abs();
        }
    }
}

/// `v ← v + |U| e` of a block right of it, `Uᵀ` m × n.
pub(in crate::linear_solver) fn add_sums(m: usize, n: usize, ut: &[f64], v: &mut [f64]) {
    by_size!(m, n, add_sums_of, (ut, v))
}

#[inline(always)]
fn add_sums_of(m: usize, n: usize, ut: &[f64], v: &mut [f64]) {
    let (ut, v) = (&ut[..m * n], &mut v[..n]);
    for r in 0..m {
        for c in 0..n {
            v[c] += ut[c * m + r].abs();
        }
    }
}

/// Largest entry of `|L| v` of a factorised diagonal block, for nonnegative `v`.
pub(in crate::linear_solver) fn lower_product(n: usize, d: &[f64], v: &[f64]) -> f64 {
    match n {
        6 => lower_product_of(6, d, v),
        3 => lower_product_of(3, d, v),
        _ => lower_product_of(n, d, v),
    }
}

#[inline(always)]
fn lower_product_of(n: usize, d: &[f64], v: &[f64]) -> f64 {
    let (d, v) = (&d[..n * n], &v[..n]);
    let row = |r: usize| (0..r).fold(v[r], |sum, c| sum + d[c * n + r].abs() * v[c]);
    (0..n).map(row).fold(0.0, larger)
}

/// Largest entry of `|L| v`, `L` m × n, for nonnegative `v`.
pub(in crate::linear_solver) fn product(m: usize, n: usize, l: &[f64], v: &[f64]) -> f64 {
    by_size!(m, n, product_of, (l, v))
}

#[inline(always)]
fn product_of(m: usize, n: usize, l: &[f64], v: &[f64]) -> f64 {
    let (l, v) = (&l[..m * n], &v[..n]);
    let row = |r: usize| (0..n).fold(0.0, |sum, c| sum + l[c * m + r].abs() * v[c]);
    (0..m).map(row).fold(0.0, larger)
}

/// The larger of two. A NaN may get lost: it propagates to a later pivot, where it is detected.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
