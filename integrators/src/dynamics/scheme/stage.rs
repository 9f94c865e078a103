//! The rows of a scheme's table.

use std::ops::Range;

/// Largest number of stages of a step.
pub const STAGES: usize = 6;

/// A stage of a step: one row of a table. See the [module](super).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stage {
    /// Position c in the step, 1 at the end.
    pub c: f64,
    /// Weights Q of h² y in the coordinates: old acceleration, then those of the stages.
    pub q: [f64; 1 + STAGES],
    /// Weights V of h y in the velocities, in the same order.
    pub v: [f64; 1 + STAGES],
}

impl Stage {
    /// A stage at c with the first weights of Q and V; all others are zero.
    pub fn new<const W: usize>(c: f64, q: [f64; W], v: [f64; W]) -> Self {
        const { assert!(W <= 1 + STAGES, "a row has at most `STAGES` + 1 weights") }
        let mut stage = Self {
            c,
            ..Self::default()
        };
        stage.q[..W].copy_from_slice(&q);
        stage.v[..W].copy_from_slice(&v);
        stage
    }

    /// The stages of a Runge-Kutta method for (q, q̇)˙ = (q̇, q̈): the weights of its table for the
    /// velocities, their product with themselves for the coordinates. A first stage at the
    /// beginning of the step is the old acceleration, not a row: it is the first column, zero for
    /// methods without one. The method ends in its last stage (stiffly accurate).
    pub fn runge_kutta<const S: usize, const W: usize>(c: [f64; S], A: [[f64; W]; S]) -> [Self; S] {
        std::array::from_fn(|i| {
            let mut q = [0.0; W];
            for (weight, row) in A[i][1..].iter().zip(&A) {
                for (q, a) in q.iter_mut().zip(row) {
                    *q += weight * a;
                }
            }
            Self::new(c[i], q, A[i])
        })
    }

    /// The weights of this row less those of another one.
    pub(super) fn less(mut self, other: &Self) -> Self {
        let pairs = |a: &mut [f64], b: &[f64]| a.iter_mut().zip(b).for_each(|(a, b)| *a -= b);
        pairs(&mut self.q, &other.q);
        pairs(&mut self.v, &other.v);
        self
    }
}

/// Inverse of the weights of the accelerations of a group of stages in its coordinates; `None` if
/// they are singular, as for an explicit stage.
pub(in crate::dynamics) fn inverse(
    stages: &[Stage],
    group: &Range<usize>,
) -> Option<[[f64; STAGES]; STAGES]> {
    let n = group.len();
    let (mut A, mut X) = ([[0.0; STAGES]; STAGES], [[0.0; STAGES]; STAGES]);
    for (i, stage) in stages[group.clone()].iter().enumerate() {
        A[i][..n].copy_from_slice(&stage.q[1 + group.start..1 + group.end]);
        X[i][i] = 1.0;
    }
    // Gauss-Jordan elimination with row interchanges.
    for k in 0..n {
        let size = |i: &usize| A[*i][k].abs();
        let best = (k..n).max_by(|i, j| size(i).total_cmp(&size(j)))?;
        A.swap(k, best);
        X.swap(k, best);
        if A[k][k].abs() < 1e-12 {
            return None;
        }
        let pivot = 1.0 / A[k][k];
        A[k] = A[k].map(|a| a * pivot);
        X[k] = X[k].map(|x| x * pivot);
        for i in (0..n).filter(|i| *i != k) {
            let factor = A[i][k];
            for c in 0..n {
                A[i][c] -= factor * A[k][c];
                X[i][c] -= factor * X[k][c];
            }
        }
    }
    Some(X)
}
