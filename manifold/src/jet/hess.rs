//! Value, gradient and Hessian.

use crate::scalar::{MAX_ORDER, Scalar};

/// A value with gradient and symmetric Hessian in `D` variables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hess<const D: usize> {
    /// Value.
    pub v: f64,
    /// Gradient.
    pub g: [f64; D],
    /// Hessian; only entries `h[i][j]` with j ≤ i are kept up to date.
    pub h: [[f64; D]; D],
}

impl<const D: usize> Hess<D> {
    /// The independent variable number `i`.
    #[inline]
    pub fn variable(v: f64, i: usize) -> Self {
        let mut out = Self::constant(v);
        out.g[i] = 1.0;
        out
    }

    /// From a value and rules for the entries of gradient and Hessian.
    #[inline(always)]
    fn filled(v: f64, g: impl Fn(usize) -> f64, h: impl Fn(usize, usize) -> f64) -> Self {
        let mut out = Self::constant(v);
        for i in 0..D {
            out.g[i] = g(i);
            for j in 0..=i {
                out.h[i][j] = h(i, j);
            }
        }
        out
    }
}

impl<const D: usize> Scalar for Hess<D> {
    const ORDER: usize = 2;

    #[inline]
    fn constant(value: f64) -> Self {
        Self {
            v: value,
            g: [0.0; D],
            h: [[0.0; D]; D],
        }
    }

    #[inline]
    fn re(&self) -> f64 {
        self.v
    }

    #[inline]
    fn compose(self, f: [f64; MAX_ORDER + 1]) -> Self {
        let bend = self.g.map(|g| f[2] * g);
        Self::filled(
            f[0],
            |i| f[1] * self.g[i],
            |i, j| f[1] * self.h[i][j] + bend[i] * self.g[j],
        )
    }
}

impl<const D: usize> Hess<D> {
    #[inline]
    fn plus(self, b: Self) -> Self {
        Self::filled(
            self.v + b.v,
            |i| self.g[i] + b.g[i],
            |i, j| self.h[i][j] + b.h[i][j],
        )
    }

    #[inline]
    fn minus(self, b: Self) -> Self {
        Self::filled(
            self.v - b.v,
            |i| self.g[i] - b.g[i],
            |i, j| self.h[i][j] - b.h[i][j],
        )
    }

    #[inline]
    fn times(self, b: Self) -> Self {
        let (p, q) = (&self.g, &b.g);
        Self::filled(
            self.v * b.v,
            |i| p[i] * b.v + self.v * q[i],
            |i, j| (self.h[i][j] * b.v + self.v * b.h[i][j]) + (p[i] * q[j] + q[i] * p[j]),
        )
    }

    #[inline]
    fn scaled(self, b: f64) -> Self {
        Self::filled(self.v * b, |i| self.g[i] * b, |i, j| self.h[i][j] * b)
    }

    #[inline]
    fn shifted(mut self, b: f64) -> Self {
        self.v += b;
        self
    }
}

operators!([const D: usize] Hess<D>);
