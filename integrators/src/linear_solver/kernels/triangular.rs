//! Triangular systems with a factorised diagonal block, for panels and for vectors.

use super::{by_size, columns, columns_mut};

/// `X ← X U⁻¹`.
pub(in crate::linear_solver) fn right_upper(m: usize, n: usize, d: &[f64], x: &mut [f64]) {
    by_size!(m, n, right_upper_fixed, right_upper_any, (d, x))
}

fn right_upper_fixed<const M: usize, const N: usize>(d: &[f64], x: &mut [f64]) {
    let (Some(d), Some(x)) = (columns::<N, N>(d), columns_mut::<M, N>(x)) else {
        return;
    };
    for c in 0..N {
        let mut column = x[c];
        for p in 0..c {
            for r in 0..M {
                column[r] -= x[p][r] * d[c][p];
            }
        }
        for r in 0..M {
            x[c][r] = column[r] * d[c][c];
        }
    }
}

fn right_upper_any(m: usize, n: usize, d: &[f64], x: &mut [f64]) {
    for c in 0..n {
        let (left, right) = x.split_at_mut(c * m);
        let column = &mut right[..m];
        for (p, done) in left.chunks_exact(m).enumerate() {
            let factor = d[c * n + p];
            for (x, y) in column.iter_mut().zip(done) {
                *x -= y * factor;
            }
        }
        for x in column {
            *x *= d[c * n + c];
        }
    }
}

/// The same with the transposed right block of a symmetric matrix as by-product: `Uᵀ = L D`.
pub(in crate::linear_solver) fn right_upper_pair(
    m: usize,
    n: usize,
    d: &[f64],
    x: &mut [f64],
    ut: &mut [f64],
) {
    by_size!(
        m,
        n,
        right_upper_pair_fixed,
        right_upper_pair_any,
        (d, x, ut)
    )
}

fn right_upper_pair_fixed<const M: usize, const N: usize>(
    d: &[f64],
    x: &mut [f64],
    ut: &mut [f64],
) {
    let (Some(d), Some(x), Some(ut)) = (
        columns::<N, N>(d),
        columns_mut::<M, N>(x),
        columns_mut::<M, N>(ut),
    ) else {
        return;
    };
    for c in 0..N {
        let mut column = x[c];
        for p in 0..c {
            for r in 0..M {
                column[r] -= x[p][r] * d[c][p];
            }
        }
        ut[c] = column;
        for r in 0..M {
            x[c][r] = column[r] * d[c][c];
        }
    }
}

fn right_upper_pair_any(m: usize, n: usize, d: &[f64], x: &mut [f64], ut: &mut [f64]) {
    right_upper_any(m, n, d, x);
    for (c, (ut, x)) in ut.chunks_exact_mut(m).zip(x.chunks_exact(m)).enumerate() {
        let pivot = 1.0 / d[c * n + c];
        for (u, l) in ut.iter_mut().zip(x) {
            *u = l * pivot;
        }
    }
}

/// `Uᵀ ← Uᵀ L⁻ᵀ`, the columns of `Uᵀ` interchanged already.
pub(in crate::linear_solver) fn left_lower(m: usize, n: usize, d: &[f64], ut: &mut [f64]) {
    by_size!(m, n, left_lower_fixed, left_lower_any, (d, ut))
}

fn left_lower_fixed<const M: usize, const N: usize>(d: &[f64], ut: &mut [f64]) {
    let (Some(d), Some(ut)) = (columns::<N, N>(d), columns_mut::<M, N>(ut)) else {
        return;
    };
    for c in 1..N {
        let mut column = ut[c];
        for p in 0..c {
            for r in 0..M {
                column[r] -= ut[p][r] * d[p][c];
            }
        }
        ut[c] = column;
    }
}

fn left_lower_any(m: usize, n: usize, d: &[f64], ut: &mut [f64]) {
    for c in 1..n {
        let (left, right) = ut.split_at_mut(c * m);
        for (p, done) in left.chunks_exact(m).enumerate() {
            let factor = d[p * n + c];
            for (x, y) in right[..m].iter_mut().zip(done) {
                *x -= y * factor;
            }
        }
    }
}

/// `y ← L⁻¹ y`, interchanges applied already.
pub(in crate::linear_solver) fn solve_lower(n: usize, d: &[f64], y: &mut [f64]) {
    match n {
        6 => solve_lower_of(6, d, y),
        3 => solve_lower_of(3, d, y),
        1 => {}
        _ => solve_lower_of(n, d, y),
    }
}

#[inline(always)]
fn solve_lower_of(n: usize, d: &[f64], y: &mut [f64]) {
    let (d, y) = (&d[..n * n], &mut y[..n]);
    for k in 0..n {
        for r in k + 1..n {
            y[r] -= d[k * n + r] * y[k];
        }
    }
}

/// `y ← U⁻¹ y`.
pub(in crate::linear_solver) fn solve_upper(n: usize, d: &[f64], y: &mut [f64]) {
    match n {
        6 => solve_upper_of(6, d, y),
        3 => solve_upper_of(3, d, y),
        1 => y[0] *= d[0],
        _ => solve_upper_of(n, d, y),
    }
}

#[inline(always)]
fn solve_upper_of(n: usize, d: &[f64], y: &mut [f64]) {
    let (d, y) = (&d[..n * n], &mut y[..n]);
    for k in (0..n).rev() {
        y[k] *= d[k * n + k];
        for r in 0..k {
            y[r] -= d[k * n + r] * y[k];
        }
    }
}
