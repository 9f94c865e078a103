//! Small matrices whose sizes are known at run time only, column by column in slices.

#![allow(non_snake_case)]

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

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Columns of a matrix in the order in which they add most to the span of those before: a QR
/// factorisation with column pivoting, in buffers made once.
#[derive(Clone, Debug, Default)]
pub(super) struct Pivoted {
    rows: usize,
    rest: Vec<f64>,
    /// What of each column is left, squared.
    squares: Vec<f64>,
    /// Which rows of each column may not be zero, a bit each: a coordinate takes part in few
    /// equations, and columns without a common row are orthogonal as they are.
    support: Vec<u64>,
    along: Vec<u64>,
    /// Columns, the largest first; only the first `steps` entries are pivots.
    pub order: Vec<usize>,
    /// What of each column, in this order, is not in the span of those before: |r_kk|.
    pub left: Vec<f64>,
    /// Orthonormal basis of the span, column by column in the same order; zero beyond the rank.
    pub basis: Vec<f64>,
}

impl Pivoted {
    /// Factorises `A`, of `rows` rows. Every column is made orthogonal twice, which is enough.
    pub(super) fn run(&mut self, rows: usize, A: &[f64]) {
        let columns = A.len().checked_div(rows).unwrap_or(0);
        let steps = rows.min(columns);
        self.rows = rows;
        self.rest.clear();
        self.rest.extend_from_slice(A);
        self.order.clear();
        self.order.extend(0..columns);
        self.left.clear();
        self.left.resize(columns, 0.0);
        self.basis.clear();
        self.basis.resize(rows * steps, 0.0);
        let words = rows.div_ceil(64);
        self.support.clear();
        self.support.resize(words * columns, 0);
        self.squares.clear();
        for c in 0..columns {
            let column = &A[c * rows..(c + 1) * rows];
            self.squares.push(dot(column, column));
            for (i, _) in column.iter().enumerate().filter(|(_, x)| **x != 0.0) {
                self.support[c * words + i / 64] |= 1 << (i % 64);
            }
        }
        for k in 0..steps {
            // The first of equal ones, so that rounding does not decide between ties.
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
            self.along.clear();
            self.along
                .extend_from_slice(&self.support[c * words..(c + 1) * words]);
            for &j in &self.order[k + 1..] {
                let support = &mut self.support[j * words..(j + 1) * words];
                if support.iter().zip(&self.along).all(|(a, b)| a & b == 0) {
                    continue;
                }
                support
                    .iter_mut()
                    .zip(&self.along)
                    .for_each(|(a, b)| *a |= b);
                let column = &mut self.rest[j * rows..(j + 1) * rows];
                for _ in 0..2 {
                    let along: f64 = bits(&self.along).map(|i| direction[i] * column[i]).sum();
                    bits(&self.along).for_each(|i| column[i] -= along * direction[i]);
                }
                self.squares[j] = bits(support).map(|i| column[i] * column[i]).sum();
            }
        }
    }

    /// How many columns are independent: what they add exceeds `tolerance` of the first.
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

/// The numbers of the bits that are set, ascending.
fn bits(words: &[u64]) -> impl Iterator<Item = usize> + '_ {
    words.iter().enumerate().flat_map(|(k, &word)| {
        let next = |w: &u64| Some(w & (w - 1)).filter(|w| *w != 0);
        let some = Some(word).filter(|w| *w != 0);
        std::iter::successors(some, next).map(move |w| 64 * k + w.trailing_zeros() as usize)
    })
}

/// The inverse of a matrix, by triangular factors of which only what is not zero is walked through:
/// every equation has few unknowns.
#[derive(Clone, Debug, Default)]
pub(super) struct Inverse {
    /// Row of the matrix behind each row of the factors.
    rows: Vec<usize>,
    lower: Entries,
    upper: Entries,
}

/// What is not zero of a triangular matrix without its diagonal: row and value, column by column.
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

    /// The next column: what is not zero among `rows` of a full one.
    fn push(&mut self, rows: std::ops::Range<usize>, column: &[f64]) {
        let all = rows.map(|i| (i, column[i]));
        self.entries.extend(all.filter(|(_, a)| *a != 0.0));
        self.starts.push(self.entries.len());
    }
}

impl Inverse {
    /// Room for any factors of an n×n matrix.
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

    /// Triangular factors in the place of `A`.
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

#[cfg(test)]
mod tests {
    use super::{Inverse, Pivoted, product, product_tr};

    #[test]
    fn dependent_columns_come_last() {
        // The third column is the sum of the first two.
        let A = [1., 2., 0., 1., 0., 1., 3., -1., 1., 3., 3., 0.];
        let mut found = Pivoted::default();
        found.run(4, &A);
        assert_eq!(found.rank(1e-12), 2);
        assert_eq!(found.order[0], 2, "the longest comes first");
        let mut gram = [0.0; 4];
        product_tr([2, 4, 2], &found.basis[..8], &found.basis[..8], &mut gram);
        let defect = [gram[0] - 1.0, gram[1], gram[2], gram[3] - 1.0];
        assert!(defect.iter().all(|d| d.abs() < 1e-15), "{gram:?}");
    }

    #[test]
    fn inverses() {
        let A = [0.0, 1.0, 2.0, 2.0, 0.0, 1.0, 1.0, 3.0, 0.0];
        let (mut left, mut inverse, mut one) = (A, [0.0; 9], [0.0; 9]);
        let mut factors = Inverse::default();
        assert!(factors.run(3, &mut left, &mut inverse));
        product([3, 3, 3], &A, &inverse, &mut one);
        for (k, x) in one.iter().enumerate() {
            let exact = if k % 4 == 0 { 1.0 } else { 0.0 };
            assert!((x - exact).abs() < 1e-15, "{one:?}");
        }
        assert!(!factors.run(2, &mut [0.0; 4], &mut [0.0; 4]));
    }
}
