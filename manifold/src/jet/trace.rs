//! The structure of a map, found by one evaluation.

use crate::scalar::{MAX_ORDER, Scalar};

/// A value with the variables on which it depends, and those in which it is not affine.
///
/// Displacements enter most maps by a sum only. Second derivatives with them vanish at every point
/// and need not be computed: the cost of K_σ is quadratic in the variables. Values are formed by
/// the operations of [`Hess`](super::Hess), in the same order, so that both take the same branches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trace {
    v: f64,
    /// Variables it depends on, one bit each.
    depends: u64,
    /// Those in which it is not affine with constant coefficients.
    nonlinear: u64,
}

impl Trace {
    /// The independent variable number `i`.
    #[inline]
    pub fn variable(v: f64, i: usize) -> Self {
        Self {
            v,
            depends: Self::mark(i),
            nonlinear: 0,
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
        self.nonlinear & Self::mark(i) != 0
    }
}

impl Scalar for Trace {
    const ORDER: usize = 2;

    #[inline]
    fn constant(v: f64) -> Self {
        Self {
            v,
            depends: 0,
            nonlinear: 0,
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
            depends: self.depends,
            nonlinear: self.depends,
        }
    }
}

impl Trace {
    #[inline]
    fn plus(self, b: Self) -> Self {
        Self {
            v: self.v + b.v,
            depends: self.depends | b.depends,
            nonlinear: self.nonlinear | b.nonlinear,
        }
    }

    #[inline]
    fn minus(self, b: Self) -> Self {
        Self {
            v: self.v - b.v,
            ..self + b
        }
    }

    #[inline]
    fn times(self, b: Self) -> Self {
        let depends = self.depends | b.depends;
        // With a constant factor nothing bends that did not before.
        let both = if self.depends != 0 && b.depends != 0 {
            depends
        } else {
            0
        };
        Self {
            v: self.v * b.v,
            depends,
            nonlinear: self.nonlinear | b.nonlinear | both,
        }
    }

    #[inline]
    fn scaled(self, b: f64) -> Self {
        Self {
            v: self.v * b,
            ..self
        }
    }

    #[inline]
    fn shifted(self, b: f64) -> Self {
        Self {
            v: self.v + b,
            ..self
        }
    }
}

operators!([] Trace);
