//! Updates of later blocks and of vectors.

use super::{by_size, columns, columns_mut};

/// `C ← C - X Yᵀ` with `C` m × n, `X` m × p, `Y` n × p.
pub(in crate::linear_solver) fn update(
    m: usize,
    n: usize,
    p: usize,
    c: &mut [f64],
    x: &[f64],
    y: &[f64],
) {
    match (m, n, p) {
        (6, 6, 6) => update_fixed::<6, 6, 6>(c, x, y),
        (3, 3, 3) => update_fixed::<3, 3, 3>(c, x, y),
        (1, 1, 1) => update_fixed::<1, 1, 1>(c, x, y),
        (6, 6, 3) => update_fixed::<6, 6, 3>(c, x, y),
        (6, 6, 1) => update_fixed::<6, 6, 1>(c, x, y),
        (2, 2, 2) => update_fixed::<2, 2, 2>(c, x, y),
        _ => update_any(m, n, p, c, x, y),
    }
}

fn update_fixed<const M: usize, const N: usize, const P: usize>(
    c: &mut [f64],
    x: &[f64],
    y: &[f64],
) {
    let (Some(c), Some(x), Some(y)) = (
        columns_mut::<M, N>(c),
        columns::<M, P>(x),
        columns::<N, P>(y),
    ) else {
        return;
    };
    for (j, column) in c.iter_mut().enumerate() {
        let mut sum = *column;
        for p in 0..P {
            for r in 0..M {
                sum[r] -= x[p][r] * y[p][j];
            }
        }
        *column = sum;
    }
}

fn update_any(m: usize, n: usize, p: usize, c: &mut [f64], x: &[f64], y: &[f64]) {
    for (x, y) in x.chunks_exact(m).zip(y.chunks_exact(n)).take(p) {
        for (column, &factor) in c.chunks_exact_mut(m).zip(y) {
            for (c, x) in column.iter_mut().zip(x) {
                *c -= x * factor;
            }
        }
    }
}

/// `y ← y - L x`, `L` m × n.
pub(in crate::linear_solver) fn subtract(m: usize, n: usize, l: &[f64], x: &[f64], y: &mut [f64]) {
    by_size!(m, n, subtract_fixed, subtract_any, (l, x, y))
}

fn subtract_fixed<const M: usize, const N: usize>(l: &[f64], x: &[f64], y: &mut [f64]) {
    let (Some(l), Some(x), Some(y)) = (
        columns::<M, N>(l),
        x.first_chunk::<N>(),
        y.first_chunk_mut::<M>(),
    ) else {
        return;
    };
    let mut sum = *y;
    for c in 0..N {
        for r in 0..M {
            sum[r] -= l[c][r] * x[c];
        }
    }
    *y = sum;
}

fn subtract_any(m: usize, n: usize, l: &[f64], x: &[f64], y: &mut [f64]) {
    for (column, &x) in l.chunks_exact(m).zip(x).take(n) {
        for (y, l) in y.iter_mut().zip(column) {
            *y -= l * x;
        }
    }
}

/// `y ← y - Uᵀᵀ x`, `Uᵀ` m × n, `x` of length m, `y` of length n.
pub(in crate::linear_solver) fn subtract_transposed(
    m: usize,
    n: usize,
    ut: &[f64],
    x: &[f64],
    y: &mut [f64],
) {
    by_size!(m, n, subtract_transposed_of, (ut, x, y))
}

#[inline(always)]
fn subtract_transposed_of(m: usize, n: usize, ut: &[f64], x: &[f64], y: &mut [f64]) {
    let (ut, x, y) = (&ut[..m * n], &x[..m], &mut y[..n]);
    for c in 0..n {
        let mut sum = 0.0;
        for r in 0..m {
            sum += ut[c * m + r] * x[r];
        }
        y[c] -= sum;
    }
}
