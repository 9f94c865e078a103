//! The structure of a map, found by one evaluation.

use crate::scalar::{MAX_ORDER, Scalar};
use std::ops::{Add, Mul, Neg, Sub};

/// A value that knows which variables it depends on, and in which of them it is not affine.
///
/// Displacements enter most maps by a sum only. Second derivatives with them vanish at every point
/// and need not be computed: the cost of K_σ is quadratic in the variables. Values are formed by
/// the operations of [`Hess`](super::Hess), in the same order, so that both take the same branches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trace {
    v: f64,
    /// Variables it depends on, one bit each.
    seen: u64,
    /// Those in which it is not affine with constant coefficients.
    bent: u64,
}

impl Trace {
    /// The independent variable number `i`.
    #[inline]
    pub fn variable(v: f64, i: usize) -> Self {
        Self {
            v,
            seen: Self::mark(i),
            bent: 0,
        }
    }

    #[inline]
    fn mark(i: usize) -> u64 {
        // Variables beyond the last bit share it: more is computed than needed, nothing is lost.
        1 << i.min(63)
    }

    /// Whether second derivatives with variable number `i` may be different from zero.
    #[inline]
    pub fn bends(&self, i: usize) -> bool {
        self.bent & Self::mark(i) != 0
    }
}

impl Scalar for Trace {
    const ORDER: usize = 2;

    #[inline]
    fn constant(v: f64) -> Self {
        Self {
            v,
            seen: 0,
            bent: 0,
        }
    }

    #[inline]
    fn re(&self) -> f64 {
        self.v
    }

    #[inline]
    fn compose(self, f: [f64; MAX_ORDER + 1]) -> Self {
        Self {
            v: f[0],
            seen: self.seen,
            bent: self.seen,
        }
    }
}

impl Add for Trace {
    type Output = Self;
    #[inline]
    fn add(self, b: Self) -> Self {
        Self {
            v: self.v + b.v,
            seen: self.seen | b.seen,
            bent: self.bent | b.bent,
        }
    }
}

impl Sub for Trace {
    type Output = Self;
    #[inline]
    fn sub(self, b: Self) -> Self {
        Self {
            v: self.v - b.v,
            ..self + b
        }
    }
}

impl Mul for Trace {
    type Output = Self;
    #[inline]
    fn mul(self, b: Self) -> Self {
        let seen = self.seen | b.seen;
        // With a constant factor nothing bends that did not before.
        let both = if self.seen != 0 && b.seen != 0 {
            seen
        } else {
            0
        };
        Self {
            v: self.v * b.v,
            seen,
            bent: self.bent | b.bent | both,
        }
    }
}

impl Neg for Trace {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { v: -self.v, ..self }
    }
}

impl Mul<f64> for Trace {
    type Output = Self;
    #[inline]
    fn mul(self, b: f64) -> Self {
        Self {
            v: self.v * b,
            ..self
        }
    }
}

impl Add<f64> for Trace {
    type Output = Self;
    #[inline]
    fn add(self, b: f64) -> Self {
        Self {
            v: self.v + b,
            ..self
        }
    }
}

derived_operators!([] Trace);
quotient_by_reciprocal!([] Trace);
