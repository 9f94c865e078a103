//! Value and gradient.

use super::{derivative, nested_order};
use crate::scalar::{MAX_ORDER, Scalar};

/// A value with its gradient in `D` variables: total order one more than `S`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grad<S, const D: usize> {
    /// Value.
    pub v: S,
    /// Partial derivatives.
    pub g: [S; D],
}

impl<S: Scalar, const D: usize> Grad<S, D> {
    /// The independent variable number `i`.
    #[inline]
    pub fn variable(v: S, i: usize) -> Self {
        let mut g = [S::zero(); D];
        g[i] = S::one();
        Self { v, g }
    }
}

impl<S: Scalar, const D: usize> Scalar for Grad<S, D> {
    const ORDER: usize = nested_order(S::ORDER, 1);

    #[inline]
    fn constant(value: f64) -> Self {
        Self {
            v: S::constant(value),
            g: [S::zero(); D],
        }
    }

    #[inline]
    fn re(&self) -> f64 {
        self.v.re()
    }

    #[inline]
    fn compose(self, f: [f64; MAX_ORDER + 1]) -> Self {
        const { assert!(Self::ORDER <= MAX_ORDER) };
        let slope = self.v.compose(derivative(f));
        Self {
            v: self.v.compose(f),
            g: self.g.map(|gi| slope * gi),
        }
    }
}

impl<S: Scalar, const D: usize> Grad<S, D> {
    #[inline]
    fn plus(mut self, b: Self) -> Self {
        self.v += b.v;
        for (x, y) in self.g.iter_mut().zip(b.g) {
            *x += y;
        }
        self
    }

    #[inline]
    fn minus(mut self, b: Self) -> Self {
        self.v -= b.v;
        for (x, y) in self.g.iter_mut().zip(b.g) {
            *x -= y;
        }
        self
    }

    #[inline]
    fn times(mut self, b: Self) -> Self {
        for (x, y) in self.g.iter_mut().zip(b.g) {
            *x = *x * b.v + self.v * y;
        }
        self.v *= b.v;
        self
    }

    #[inline]
    fn scaled(self, b: f64) -> Self {
        Self {
            v: self.v * b,
            g: self.g.map(|x| x * b),
        }
    }

    #[inline]
    fn shifted(mut self, b: f64) -> Self {
        self.v = self.v + b;
        self
    }
}

operators!([S: Scalar, const D: usize] Grad<S, D>);
