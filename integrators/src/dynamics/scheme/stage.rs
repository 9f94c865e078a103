//! The rows of a scheme's table.

use nalgebra::SMatrix;
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
    let mut A = SMatrix::<f64, STAGES, STAGES>::identity();
    for (i, stage) in stages[group.clone()].iter().enumerate() {
        for (j, weight) in stage.q[1..][group.clone()].iter().enumerate() {
            A[(i, j)] = *weight;
        }
    }
    let inverse = A.try_inverse()?;
    // By rows. Larger entries are those of weights that are singular but for rounding.
    (inverse.amax() < 1e12).then(|| inverse.transpose().into())
}
