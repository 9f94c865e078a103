//! Dense kernels on small column-major blocks.
//!
//! Every kernel exists once, generic over its extents. [`by_size!`] calls it with constant extents
//! for the sizes that occur in practice (1: joint coordinates, 3: planar or spherical, 6: nodes),
//! where the compiler unrolls and keeps columns in registers, and a twin with extents known at run
//! time does the rest.
//!
//! A panel's blocks below the diagonal are kept as `L` (m × n) and those to its right transposed,
//! `Uᵀ` (m × n too), so that all kernels run down contiguous columns of length m.

/// Calls `$fixed::<m, n>` for common sizes, `$any(m, n, ...)` otherwise.
macro_rules! by_size {
    ($m:expr, $n:expr, $fixed:ident, $any:ident, ($($argument:expr),*)) => {
        match ($m, $n) {
            (6, 6) => $fixed::<6, 6>($($argument),*),
            (3, 3) => $fixed::<3, 3>($($argument),*),
            (1, 1) => $fixed::<1, 1>($($argument),*),
            (6, 3) => $fixed::<6, 3>($($argument),*),
            (3, 6) => $fixed::<3, 6>($($argument),*),
            (6, 1) => $fixed::<6, 1>($($argument),*),
            (1, 6) => $fixed::<1, 6>($($argument),*),
            (2, 2) => $fixed::<2, 2>($($argument),*),
            (m, n) => $any(m, n, $($argument),*),
        }
    };
}

/// Rows are left in place as long as the diagonal is at least this part of its column.
///
/// A lone large entry would win under plain partial pivoting only to gain growth by a factor 10,
/// and an interchange costs the symmetry and a branch nobody predicts.
const KEEP_DIAGONAL: f64 = 0.1;

/// Columns of a block with constant extents.
#[inline(always)]
fn columns<const M: usize, const N: usize>(x: &[f64]) -> Option<&[[f64; M]; N]> {
    x.as_chunks::<M>().0.first_chunk()
}

#[inline(always)]
fn columns_mut<const M: usize, const N: usize>(x: &mut [f64]) -> Option<&mut [[f64; M]; N]> {
    x.as_chunks_mut::<M>().0.first_chunk_mut()
}

/// What a diagonal block's factorisation found.
pub(super) struct Pivots {
    /// Smallest pivot, or 0 if one is NaN.
    pub smallest: f64,
    /// Largest pivot.
    pub largest: f64,
    /// Whether rows were interchanged.
    pub swapped: bool,
}

/// Factorises a diagonal block in place, `P D = L U`, the reciprocals of the pivots on the
/// diagonal and the interchanges in `swaps`. Pivots below `floor` are replaced by it.
pub(super) fn lu(n: usize, d: &mut [f64], swaps: &mut [u32], floor: f64) -> Pivots {
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
    // Spelled out, so that every step has constant extents: a diagonal block is on the critical
    // path of a chain, where nothing else can be done meanwhile.
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
        // Comparisons arranged so that NaN ends up as the smallest and stays there.
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

/// `X ← X U⁻¹`.
pub(super) fn right_upper(m: usize, n: usize, d: &[f64], x: &mut [f64]) {
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
pub(super) fn right_upper_pair(m: usize, n: usize, d: &[f64], x: &mut [f64], ut: &mut [f64]) {
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
pub(super) fn left_lower(m: usize, n: usize, d: &[f64], ut: &mut [f64]) {
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

/// `C ← C - X Yᵀ` with `C` m × n, `X` m × p, `Y` n × p.
pub(super) fn update(m: usize, n: usize, p: usize, c: &mut [f64], x: &[f64], y: &[f64]) {
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

/// `y ← L⁻¹ y`, interchanges applied already.
pub(super) fn solve_lower(n: usize, d: &[f64], y: &mut [f64]) {
    match n {
        6 => solve_lower_fixed::<6>(d, y),
        3 => solve_lower_fixed::<3>(d, y),
        1 => {}
        _ => {
            for k in 0..n {
                let (left, right) = y.split_at_mut(k + 1);
                for (y, l) in right.iter_mut().zip(&d[k * n + k + 1..(k + 1) * n]) {
                    *y -= l * left[k];
                }
            }
        }
    }
}

fn solve_lower_fixed<const N: usize>(d: &[f64], y: &mut [f64]) {
    let (Some(d), Some(y)) = (columns::<N, N>(d), y.first_chunk_mut::<N>()) else {
        return;
    };
    for k in 0..N {
        for r in k + 1..N {
            y[r] -= d[k][r] * y[k];
        }
    }
}

/// `y ← U⁻¹ y`.
pub(super) fn solve_upper(n: usize, d: &[f64], y: &mut [f64]) {
    match n {
        6 => solve_upper_fixed::<6>(d, y),
        3 => solve_upper_fixed::<3>(d, y),
        1 => y[0] *= d[0],
        _ => {
            for k in (0..n).rev() {
                let (left, right) = y.split_at_mut(k);
                right[0] *= d[k * n + k];
                for (y, u) in left.iter_mut().zip(&d[k * n..]) {
                    *y -= u * right[0];
                }
            }
        }
    }
}

fn solve_upper_fixed<const N: usize>(d: &[f64], y: &mut [f64]) {
    let (Some(d), Some(y)) = (columns::<N, N>(d), y.first_chunk_mut::<N>()) else {
        return;
    };
    for k in (0..N).rev() {
        y[k] *= d[k][k];
        for r in 0..k {
            y[r] -= d[k][r] * y[k];
        }
    }
}

/// `y ← y - L x`, `L` m × n.
pub(super) fn subtract(m: usize, n: usize, l: &[f64], x: &[f64], y: &mut [f64]) {
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
pub(super) fn subtract_transposed(m: usize, n: usize, ut: &[f64], x: &[f64], y: &mut [f64]) {
    by_size!(
        m,
        n,
        subtract_transposed_fixed,
        subtract_transposed_any,
        (ut, x, y)
    )
}

fn subtract_transposed_fixed<const M: usize, const N: usize>(ut: &[f64], x: &[f64], y: &mut [f64]) {
    let (Some(ut), Some(x), Some(y)) = (
        columns::<M, N>(ut),
        x.first_chunk::<M>(),
        y.first_chunk_mut::<N>(),
    ) else {
        return;
    };
    for c in 0..N {
        let mut sum = 0.0;
        for r in 0..M {
            sum += ut[c][r] * x[r];
        }
        y[c] -= sum;
    }
}

fn subtract_transposed_any(m: usize, n: usize, ut: &[f64], x: &[f64], y: &mut [f64]) {
    for (y, column) in y.iter_mut().zip(ut.chunks_exact(m)).take(n) {
        *y -= column.iter().zip(x).map(|(u, x)| u * x).sum::<f64>();
    }
}

/// `out ← R B C`, twice, for the scales of rows and columns; returns the sum of squares.
pub(super) fn scale(
    m: usize,
    n: usize,
    block: &[f64],
    rows: &[f64],
    columns: &[f64],
    out: &mut [f64],
    copy: &mut [f64],
) -> f64 {
    by_size!(
        m,
        n,
        scale_fixed,
        scale_any,
        (block, rows, columns, out, copy)
    )
}

fn scale_fixed<const M: usize, const N: usize>(
    block: &[f64],
    rows: &[f64],
    scales: &[f64],
    out: &mut [f64],
    copy: &mut [f64],
) -> f64 {
    let (Some(block), Some(rows), Some(scales), Some(out), Some(copy)) = (
        columns::<M, N>(block),
        rows.first_chunk::<M>(),
        scales.first_chunk::<N>(),
        columns_mut::<M, N>(out),
        columns_mut::<M, N>(copy),
    ) else {
        return f64::NAN;
    };
    let mut sum = [0.0; M];
    for c in 0..N {
        for r in 0..M {
            let value = block[c][r] * rows[r] * scales[c];
            out[c][r] = value;
            copy[c][r] = value;
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
    copy: &mut [f64],
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
    copy[..m * n].copy_from_slice(&out[..m * n]);
    sum
}

/// `out ← (C B R)ᵀ`, twice, `B` n × m, `out` m × n; returns the sum of squares.
pub(super) fn scale_transposed(
    m: usize,
    n: usize,
    block: &[f64],
    rows: &[f64],
    columns: &[f64],
    out: &mut [f64],
    copy: &mut [f64],
) -> f64 {
    by_size!(
        m,
        n,
        scale_transposed_fixed,
        scale_transposed_any,
        (block, rows, columns, out, copy)
    )
}

fn scale_transposed_fixed<const M: usize, const N: usize>(
    block: &[f64],
    rows: &[f64],
    scales: &[f64],
    out: &mut [f64],
    copy: &mut [f64],
) -> f64 {
    let (Some(block), Some(rows), Some(scales), Some(out), Some(copy)) = (
        columns::<N, M>(block),
        rows.first_chunk::<M>(),
        scales.first_chunk::<N>(),
        columns_mut::<M, N>(out),
        columns_mut::<M, N>(copy),
    ) else {
        return f64::NAN;
    };
    let mut sum = [0.0; M];
    for c in 0..N {
        for r in 0..M {
            let value = block[r][c] * rows[r] * scales[c];
            out[c][r] = value;
            copy[c][r] = value;
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
    copy: &mut [f64],
) -> f64 {
    let mut sum = 0.0;
    for (c, (out, scale)) in out.chunks_exact_mut(m).zip(columns).take(n).enumerate() {
        for (r, (out, row)) in out.iter_mut().zip(rows).enumerate() {
            let value = block[c + n * r] * row * scale;
            *out = value;
            sum += value * value;
        }
    }
    copy[..m * n].copy_from_slice(&out[..m * n]);
    sum
}
