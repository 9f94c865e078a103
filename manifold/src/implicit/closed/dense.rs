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
        for k in 0..steps {
            let size = |rest: &[f64], c: usize| {
                let column = &rest[c * rows..(c + 1) * rows];
                dot(column, column)
            };
            // The first of equal ones, so that rounding does not decide between ties.
            let mut best = k;
            for j in k + 1..columns {
                let now = size(&self.rest, self.order[best]);
                if size(&self.rest, self.order[j]) > now * (1.0 + 1e-12) {
                    best = j;
                }
            }
            self.order.swap(k, best);
            let c = self.order[k];
            let left = size(&self.rest, c).sqrt();
            self.left[k] = left;
            if left.is_nan() || left <= 0.0 {
                break;
            }
            let direction = &mut self.basis[k * rows..(k + 1) * rows];
            for (d, x) in direction.iter_mut().zip(&self.rest[c * rows..]) {
                *d = x / left;
            }
            for &j in &self.order[k + 1..] {
                let column = &mut self.rest[j * rows..(j + 1) * rows];
                for _ in 0..2 {
                    let along = dot(direction, column);
                    for (x, d) in column.iter_mut().zip(&*direction) {
                        *x -= along * d;
                    }
                }
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

/// Writes the inverse of `A` (n×n, destroyed) into `out` by Gauss–Jordan elimination with row
/// pivoting; false for a singular matrix.
pub(super) fn invert(n: usize, A: &mut [f64], out: &mut [f64]) -> bool {
    out.fill(0.0);
    for k in 0..n {
        out[k + k * n] = 1.0;
    }
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
            for j in 0..n {
                A.swap(k + j * n, pivot + j * n);
                out.swap(k + j * n, pivot + j * n);
            }
        }
        let factor = 1.0 / A[k + k * n];
        for j in 0..n {
            A[k + j * n] *= factor;
            out[k + j * n] *= factor;
        }
        for i in (0..n).filter(|&i| i != k) {
            let factor = A[i + k * n];
            if factor != 0.0 {
                for j in 0..n {
                    A[i + j * n] -= factor * A[k + j * n];
                    out[i + j * n] -= factor * out[k + j * n];
                }
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::{Pivoted, invert, product, product_tr};

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
        assert!(invert(3, &mut left, &mut inverse));
        product([3, 3, 3], &A, &inverse, &mut one);
        for (k, x) in one.iter().enumerate() {
            let exact = if k % 4 == 0 { 1.0 } else { 0.0 };
            assert!((x - exact).abs() < 1e-15, "{one:?}");
        }
        assert!(!invert(2, &mut [0.0; 4], &mut [0.0; 4]));
    }
}
