//! Factorisation of a diagonal block.

use super::columns_mut;

/// Rows are not interchanged as long as the diagonal is at least this part of its column.
///
/// A lone large entry would win under plain partial pivoting only to gain growth by a factor 10,
/// and an interchange costs the symmetry and a branch nobody predicts.
const KEEP_DIAGONAL: f64 = 0.1;

/// Result of the factorisation of a diagonal block.
pub(in crate::linear_solver) struct Pivots {
    /// Smallest pivot, or 0 if one is NaN.
    pub smallest: f64,
    /// Largest pivot.
    pub largest: f64,
    /// Whether rows were interchanged.
    pub swapped: bool,
}

/// Factorises a diagonal block in place, `P D = L U`, the reciprocals of the pivots on the
/// diagonal and the interchanges in `swaps`. Pivots below `floor` are replaced by it.
pub(in crate::linear_solver) fn lu(
    n: usize,
    d: &mut [f64],
    swaps: &mut [u32],
    floor: f64,
) -> Pivots {
    match n {
        6 => lu_fixed::<6>(d, swaps, floor),
        3 => lu_fixed::<3>(d, swaps, floor),
        2 => lu_fixed::<2>(d, swaps, floor),
        1 => lu_fixed::<1>(d, swaps, floor),
        _ => lu_any(n, d, swaps, floor),
    }
}

fn lu_fixed<const N: usize>(d: &mut [f64], swaps: &mut [u32], floor: f64) -> Pivots {
    let mut pivots = Pivots::new();
    let Some(block) = columns_mut::<N, N>(d) else {
        return pivots;
    };
    // Unrolled, so that every step has constant extents: a diagonal block is on the critical path
    // of a chain.
    let mut d = *block;
    step::<N, 0>(&mut d, swaps, floor, &mut pivots);
    step::<N, 1>(&mut d, swaps, floor, &mut pivots);
    step::<N, 2>(&mut d, swaps, floor, &mut pivots);
    step::<N, 3>(&mut d, swaps, floor, &mut pivots);
    step::<N, 4>(&mut d, swaps, floor, &mut pivots);
    step::<N, 5>(&mut d, swaps, floor, &mut pivots);
    *block = d;
    pivots
}

/// Elimination of one column.
#[inline(always)]
fn step<const N: usize, const K: usize>(
    d: &mut [[f64; N]; N],
    swaps: &mut [u32],
    floor: f64,
    pivots: &mut Pivots,
) {
    if K >= N {
        return;
    }
    let size = d[K][K].abs();
    let mut keep = true;
    for r in K + 1..N {
        keep &= size >= KEEP_DIAGONAL * d[K][r].abs();
    }
    if !keep {
        interchange(d, K, swaps, pivots);
    }
    let reciprocal = pivots.accept(d[K][K], floor);
    for r in K + 1..N {
        d[K][r] *= reciprocal;
    }
    d[K][K] = reciprocal;
    for c in K + 1..N {
        let factor = d[c][K];
        for r in K + 1..N {
            d[c][r] -= d[K][r] * factor;
        }
    }
}

#[cold]
#[inline(never)]
fn interchange<const N: usize>(
    d: &mut [[f64; N]; N],
    k: usize,
    swaps: &mut [u32],
    pivots: &mut Pivots,
) {
    let mut row = k;
    for r in k + 1..N {
        if d[k][r].abs() > d[k][row].abs() {
            row = r;
        }
    }
    pivots.swap(swaps, N, k, row);
    for column in d.iter_mut() {
        column.swap(k, row);
    }
}

fn lu_any(n: usize, d: &mut [f64], swaps: &mut [u32], floor: f64) -> Pivots {
    let mut pivots = Pivots::new();
    for k in 0..n {
        let column = &d[k * n..(k + 1) * n];
        let mut row = k;
        for r in k + 1..n {
            if column[r].abs() > column[row].abs() {
                row = r;
            }
        }
        if !(column[k].abs() >= KEEP_DIAGONAL * column[row].abs()) {
            pivots.swap(swaps, n, k, row);
            for column in d.chunks_exact_mut(n) {
                column.swap(k, row);
            }
        }
        let reciprocal = pivots.accept(d[k * n + k], floor);
        let (left, right) = d.split_at_mut((k + 1) * n);
        let lower = &mut left[k * n..];
        lower[k] = reciprocal;
        for l in &mut lower[k + 1..] {
            *l *= reciprocal;
        }
        for column in right.chunks_exact_mut(n) {
            let factor = column[k];
            for (x, l) in column[k + 1..].iter_mut().zip(&lower[k + 1..]) {
                *x -= l * factor;
            }
        }
    }
    pivots
}

impl Pivots {
    #[inline(always)]
    fn new() -> Self {
        Self {
            smallest: f64::INFINITY,
            largest: 0.0,
            swapped: false,
        }
    }

    #[inline(always)]
    fn accept(&mut self, pivot: f64, floor: f64) -> f64 {
        let mut pivot = pivot;
        if pivot.abs() < floor {
            pivot = floor.copysign(pivot);
        }
        let size = pivot.abs();
        // NaN counts as smallest.
        self.smallest = if size >= self.smallest {
            self.smallest
        } else {
            size
        };
        self.largest = self.largest.max(size);
        1.0 / pivot
    }

    #[cold]
    fn swap(&mut self, swaps: &mut [u32], n: usize, k: usize, row: usize) {
        if !self.swapped {
            for (i, swap) in swaps[..n].iter_mut().enumerate() {
                *swap = i as u32;
            }
            self.swapped = true;
        }
        swaps[k] = row as u32;
    }
}
