//! Small matrices of sizes known only at run time, column by column in slices.

use std::ops::Range;

/// out = A B, with A m×k and B k×n.
pub(super) fn product([m, k, n]: [usize; 3], A: &[f64], B: &[f64], out: &mut [f64]) {
    for j in 0..n {
        let column = &mut out[j * m..(j + 1) * m];
        column.fill(0.0);
        for l in 0..k {
            let b = B[l + j * k];
            if b != 0.0 {
                for (o, a) in column.iter_mut().zip(&A[l * m..(l + 1) * m]) {
                    *o += a * b;
                }
            }
        }
    }
}

/// out = Aᵀ B, with A k×m and B k×n.
pub(super) fn product_tr([m, k, n]: [usize; 3], A: &[f64], B: &[f64], out: &mut [f64]) {
    for j in 0..n {
        for i in 0..m {
            let (a, b) = (&A[i * k..(i + 1) * k], &B[j * k..(j + 1) * k]);
            out[i + j * m] = a.iter().zip(b).map(|(a, b)| a * b).sum();
        }
    }
}

pub(super) fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Four sums side by side, for vector instructions.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (mut a, mut b) = (a.chunks_exact(4), b.chunks_exact(4));
    for (a, b) in a.by_ref().zip(b.by_ref()) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    let rest = a.remainder().iter().zip(b.remainder());
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest.map(|(a, b)| a * b).sum::<f64>()
}

/// x −= (d·x) d; false if x has no component along d.
fn subtract(d: &[f64], x: &mut [f64]) -> bool {
    let along = dot(d, x);
    x.iter_mut().zip(d).for_each(|(x, d)| *x -= along * d);
    along != 0.0
}

/// QR factorisation with column pivoting, in preallocated buffers: columns in the order in which
/// they add most to the span of the earlier ones.
#[derive(Clone, Debug, Default)]
pub(super) struct Pivoted {
    rows: usize,
    rest: Vec<f64>,
    /// Remaining part of each column, squared.
    squares: Vec<f64>,
    /// The rows of each column that may not be zero.
    ranges: Vec<Range<usize>>,
    /// Columns, the largest first; only the first `steps` entries are pivots.
    pub order: Vec<usize>,
    /// Part of each column, in this order, outside the span of the earlier ones: |r_kk|.
    pub left: Vec<f64>,
    /// Orthonormal basis of the span, column by column in the same order; zero beyond the rank.
    pub basis: Vec<f64>,
}

impl Pivoted {
    /// Factorises `A`, of `rows` rows. A column with a small remainder is orthogonalised twice,
    /// which is enough.
    pub(super) fn run(&mut self, rows: usize, A: &[f64]) {
        self.load(rows, A);
        let columns = self.order.len();
        for k in 0..rows.min(columns) {
            // The first of equal ones, so that rounding does not decide ties.
            let mut best = k;
            for j in k + 1..columns {
                let now = self.squares[self.order[best]];
                if self.squares[self.order[j]] > now * (1.0 + 1e-12) {
                    best = j;
                }
            }
            self.order.swap(k, best);
            let c = self.order[k];
            let left = self.squares[c].sqrt();
            self.left[k] = left;
            if left.is_nan() || left <= 0.0 {
                break;
            }
            let direction = &mut self.basis[k * rows..(k + 1) * rows];
            for (d, x) in direction.iter_mut().zip(&self.rest[c * rows..]) {
                *d = x / left;
            }
            let range = self.ranges[c].clone();
            let direction = &direction[range.clone()];
            for &j in &self.order[k + 1..] {
                let column = &mut self.rest[j * rows..(j + 1) * rows];
                let before = self.squares[j];
                if before == 0.0 || !subtract(direction, &mut column[range.clone()]) {
                    continue;
                }
                let all = &mut self.ranges[j];
                *all = all.start.min(range.start)..all.end.max(range.end);
                let mut now = dot(&column[all.clone()], &column[all.clone()]);
                if now < 0.5 * before {
                    subtract(direction, &mut column[range.clone()]);
                    now = dot(&column[all.clone()], &column[all.clone()]);
                }
                self.squares[j] = now;
            }
        }
    }

    /// Takes over the columns of `A`.
    fn load(&mut self, rows: usize, A: &[f64]) {
        let columns = A.len().checked_div(rows).unwrap_or(0);
        self.rows = rows;
        self.rest.clear();
        self.rest.extend_from_slice(A);
        self.order.clear();
        self.order.extend(0..columns);
        self.left.clear();
        self.left.resize(columns, 0.0);
        self.basis.clear();
        self.basis.resize(rows * rows.min(columns), 0.0);
        self.squares.clear();
        self.ranges.clear();
        for c in 0..columns {
            let column = &A[c * rows..(c + 1) * rows];
            self.squares.push(dot(column, column));
            let mut some = (0..rows).filter(|&i| column[i] != 0.0);
            let first = some.next().unwrap_or(0);
            let last = some.next_back().unwrap_or(first);
            self.ranges.push(first..last + 1);
        }
    }

    /// Number of independent columns: those whose part exceeds `tolerance` of the first.
    pub(super) fn rank(&self, tolerance: f64) -> usize {
        let first = self.left.first().copied().unwrap_or(0.0);
        let enough = |left: &&f64| **left > tolerance * first;
        self.left.iter().take_while(enough).count()
    }

    /// Direction `k` of the basis.
    pub(super) fn direction(&self, k: usize) -> &[f64] {
        &self.basis[k * self.rows..(k + 1) * self.rows]
    }
}

/// Inverse of a matrix by sparse triangular factors: every equation has few unknowns.
#[derive(Clone, Debug, Default)]
pub(super) struct Inverse {
    /// Row of the matrix for each row of the factors.
    rows: Vec<usize>,
    lower: Entries,
    upper: Entries,
}

/// Nonzeros of a triangular matrix without its diagonal: row and value, column by column.
#[derive(Clone, Debug, Default)]
struct Entries {
    starts: Vec<usize>,
    entries: Vec<(usize, f64)>,
}

impl Entries {
    fn clear(&mut self) {
        self.entries.clear();
        self.starts.clear();
        self.starts.push(0);
    }

    fn of(&self, column: usize) -> &[(usize, f64)] {
        &self.entries[self.starts[column]..self.starts[column + 1]]
    }

    /// Appends a column: the nonzeros among `rows` of a full one.
    fn push(&mut self, rows: Range<usize>, column: &[f64]) {
        let all = rows.map(|i| (i, column[i]));
        self.entries.extend(all.filter(|(_, a)| *a != 0.0));
        self.starts.push(self.entries.len());
    }
}

impl Inverse {
    /// Reserves space for any factors of an n×n matrix.
    pub(super) fn reserve(&mut self, n: usize) {
        self.rows.reserve(n);
        for part in [&mut self.lower, &mut self.upper] {
            part.starts.reserve(n + 1);
            part.entries.reserve(n * n.saturating_sub(1) / 2);
        }
    }

    /// Writes the inverse of `A` (n×n, destroyed) into `out`, by Gaussian elimination with row
    /// pivoting; false for a singular matrix.
    pub(super) fn run(&mut self, n: usize, A: &mut [f64], out: &mut [f64]) -> bool {
        if !self.factorise(n, A) {
            return false;
        }
        self.lower.clear();
        self.upper.clear();
        for (k, column) in A.chunks_exact(n.max(1)).enumerate() {
            self.lower.push(k + 1..n, column);
            self.upper.push(0..k, column);
        }
        out.fill(0.0);
        for (i, &j) in self.rows.iter().enumerate() {
            let x = &mut out[j * n..(j + 1) * n];
            x[i] = 1.0;
            for k in i..n {
                let factor = x[k];
                if factor != 0.0 {
                    self.lower
                        .of(k)
                        .iter()
                        .for_each(|&(i, l)| x[i] -= l * factor);
                }
            }
            for k in (0..n).rev() {
                x[k] /= A[k + k * n];
                let factor = x[k];
                if factor != 0.0 {
                    self.upper
                        .of(k)
                        .iter()
                        .for_each(|&(i, u)| x[i] -= u * factor);
                }
            }
        }
        true
    }

    /// Factorises `A` in place.
    fn factorise(&mut self, n: usize, A: &mut [f64]) -> bool {
        self.rows.clear();
        self.rows.extend(0..n);
        for k in 0..n {
            let mut pivot = k;
            for i in k + 1..n {
                if A[i + k * n].abs() > A[pivot + k * n].abs() {
                    pivot = i;
                }
            }
            let size = A[pivot + k * n].abs();
            if size.is_nan() || size <= f64::MIN_POSITIVE {
                return false;
            }
            if pivot != k {
                self.rows.swap(pivot, k);
                (0..n).for_each(|j| A.swap(k + j * n, pivot + j * n));
            }
            let (before, after) = A.split_at_mut((k + 1) * n);
            let column = &mut before[k * n..];
            let factor = 1.0 / column[k];
            column[k + 1..].iter_mut().for_each(|a| *a *= factor);
            self.lower.clear();
            self.lower.push(k + 1..n, column);
            for column in after.chunks_exact_mut(n) {
                let a = column[k];
                if a != 0.0 {
                    (self.lower.of(0).iter()).for_each(|&(i, l)| column[i] -= l * a);
                }
            }
        }
        true
    }
}
