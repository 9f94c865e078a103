//! Small factorisations of fixed size: which columns span the rest, and an inverse.

#![allow(non_snake_case)]

use nalgebra::{SMatrix, SVector};

/// QR factorisation with column pivoting: columns in the order in which they add most to the span
/// of the earlier ones.
pub(super) struct Pivoted<const R: usize, const C: usize> {
    /// Columns, the largest first; only the first min(R, C) entries are pivots.
    pub order: [usize; C],
    /// Part of each column, in this order, outside the span of the earlier ones: |r_kk|.
    pub left: [f64; C],
    /// Orthonormal basis of the span, column by column in the same order; zero beyond the rank.
    pub basis: SMatrix<f64, R, C>,
}

impl<const R: usize, const C: usize> Pivoted<R, C> {
    /// Number of independent columns: those whose part exceeds `tolerance` of the first.
    pub(super) fn rank(&self, tolerance: f64) -> usize {
        let enough = |left: &&f64| **left > tolerance * self.left[0];
        self.left.iter().take_while(enough).count()
    }
}

/// Gram–Schmidt with pivoting; every column is made orthogonal twice, which is enough.
pub(super) fn pivoted<const R: usize, const C: usize>(A: &SMatrix<f64, R, C>) -> Pivoted<R, C> {
    let mut rest = *A;
    let mut out = Pivoted {
        order: std::array::from_fn(|k| k),
        left: [0.0; C],
        basis: SMatrix::zeros(),
    };
    for k in 0..C.min(R) {
        let norm = |c: usize| rest.column(c).norm_squared();
        // The first of equal ones, so that rounding does not decide ties.
        let mut best = k;
        for j in k + 1..C {
            if norm(out.order[j]) > norm(out.order[best]) * (1.0 + 1e-12) {
                best = j;
            }
        }
        out.order.swap(k, best);
        let column = out.order[k];
        let left = rest.column(column).norm();
        out.left[k] = left;
        if left.is_nan() || left <= 0.0 {
            break;
        }
        let direction: SVector<f64, R> = rest.column(column) / left;
        out.basis.set_column(k, &direction);
        for &j in &out.order[k + 1..] {
            for _ in 0..2 {
                let along = direction.dot(&rest.column(j));
                for i in 0..R {
                    rest[(i, j)] -= along * direction[i];
                }
            }
        }
    }
    out
}

/// The inverse by Gauss–Jordan elimination with row pivoting; `None` for a singular matrix.
pub(super) fn inverse<const N: usize>(A: &SMatrix<f64, N, N>) -> Option<SMatrix<f64, N, N>> {
    let mut a = *A;
    let mut b = SMatrix::<f64, N, N>::identity();
    for k in 0..N {
        let mut pivot = k;
        for i in k + 1..N {
            if a[(i, k)].abs() > a[(pivot, k)].abs() {
                pivot = i;
            }
        }
        let size = a[(pivot, k)].abs();
        if size.is_nan() || size <= f64::MIN_POSITIVE {
            return None;
        }
        a.swap_rows(k, pivot);
        b.swap_rows(k, pivot);
        let factor = 1.0 / a[(k, k)];
        for j in 0..N {
            a[(k, j)] *= factor;
            b[(k, j)] *= factor;
        }
        for i in (0..N).filter(|&i| i != k) {
            let factor = a[(i, k)];
            if factor != 0.0 {
                for j in 0..N {
                    let (of_a, of_b) = (a[(k, j)], b[(k, j)]);
                    a[(i, j)] -= factor * of_a;
                    b[(i, j)] -= factor * of_b;
                }
            }
        }
    }
    Some(b)
}

#[cfg(test)]
mod tests {
    use super::{inverse, pivoted};
    use nalgebra::{Matrix3, SMatrix};

    #[test]
    fn dependent_columns_come_last() {
        // The third column is the sum of the first two.
        let A = SMatrix::<f64, 4, 3>::from_columns(&[
            [1.0, 2.0, 0.0, 1.0].into(),
            [0.0, 1.0, 3.0, -1.0].into(),
            [1.0, 3.0, 3.0, 0.0].into(),
        ]);
        let found = pivoted(&A);
        assert_eq!(found.rank(1e-12), 2);
        assert_eq!(found.order[0], 2, "the longest comes first");
        let Q = found.basis.fixed_columns::<2>(0).into_owned();
        assert!((Q.tr_mul(&Q) - nalgebra::Matrix2::identity()).norm() < 1e-15);
        assert!((Q * Q.transpose() * A - A).norm() < 1e-14);
    }

    #[test]
    fn inverses() {
        let A = Matrix3::new(0.0, 2.0, 1.0, 1.0, 0.0, 3.0, 2.0, 1.0, 0.0);
        let found = inverse(&A).map(|B| (A * B - Matrix3::identity()).norm());
        assert!(found.is_some_and(|defect| defect < 1e-15), "{found:?}");
        assert!(inverse(&Matrix3::<f64>::zeros()).is_none());
    }
}
