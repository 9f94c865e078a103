//! Factorisation of a diagonal block.

/// Rows are not interchanged as long as the diagonal is at least this part of its column.
///
/// Plain partial pivoting would interchange rows more often, to limit growth to less than this factor
/// of 10; an interchange loses the symmetry and costs a mispredicted branch.
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
/// diagonal and the interchanges in `swaps`.
pub(in crate::linear_solver) fn lu(n: usize, d: &mut [f64], swaps: &mut [u32]) -> Pivots {
    match n {
        6 => lu_of(6, d, swaps),
        3 => lu_of(3, d, swaps),
        2 => lu_of(2, d, swaps),
        1 => lu_of(1, d, swaps),
        _ => lu_of(n, d, swaps),
    }
}

/// The same with literal extents, for which the compiler unrolls: a diagonal block is on the critical
/// path of a chain.
#[inline(always)]
fn lu_of(n: usize, d: &mut [f64], swaps: &mut [u32]) -> Pivots {
    let mut pivots = Pivots::new();
    let d = &mut d[..n * n];
    for k in 0..n {
        let size = d[k * n + k].abs();
        let mut keep = true;
        for r in k + 1..n {
            keep &= size >= KEEP_DIAGONAL * d[k * n + r].abs();
        }
        if !keep {
            interchange(n, k, d, swaps, &mut pivots);
        }
        let (left, right) = d.split_at_mut((k + 1) * n);
        let lower = &mut left[k * n..];
        let reciprocal = pivots.accept(lower[k]);
        for r in k + 1..n {
            lower[r] *= reciprocal;
        }
        lower[k] = reciprocal;
        for column in right.chunks_exact_mut(n) {
            let factor = column[k];
            for r in k + 1..n {
                column[r] -= lower[r] * factor;
            }
        }
    }
    pivots
}

#[cold]
#[inline(never)]
fn interchange(n: usize, k: usize, d: &mut [f64], swaps: &mut [u32], pivots: &mut Pivots) {
    let mut row = k;
    for r in k + 1..n {
        if d[k * n + r].abs() > d[k * n + row].abs() {
            row = r;
        }
    }
    pivots.swap(swaps, n, k, row);
    for column in d.chunks_exact_mut(n) {
        column.swap(k, row);
    }
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
    fn accept(&mut self, pivot: f64) -> f64 {
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
