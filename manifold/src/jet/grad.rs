//! Value and gradient.

use super::derivative;
use crate::scalar::{MAX_ORDER, Scalar};
use std::ops::{Add, Mul, Neg, Sub};

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
    const ORDER: usize = {
        assert!(
            S::ORDER < MAX_ORDER,
            "jets nest to total order four: differentiate once inside a map or an energy, not twice"
        );
        S::ORDER + 1
    };

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

impl<S: Scalar, const D: usize> Add for Grad<S, D> {
    type Output = Self;
    #[inline]
    fn add(mut self, b: Self) -> Self {
        self.v += b.v;
        for (x, y) in self.g.iter_mut().zip(b.g) {
            *x += y;
        }
        self
    }
}

impl<S: Scalar, const D: usize> Sub for Grad<S, D> {
    type Output = Self;
    #[inline]
    fn sub(mut self, b: Self) -> Self {
        self.v -= b.v;
        for (x, y) in self.g.iter_mut().zip(b.g) {
            *x -= y;
        }
        self
    }
}

impl<S: Scalar, const D: usize> Mul for Grad<S, D> {
    type Output = Self;
    #[inline]
    fn mul(mut self, b: Self) -> Self {
        for (x, y) in self.g.iter_mut().zip(b.g) {
            *x = *x * b.v + self.v * y;
        }
        self.v *= b.v;
        self
    }
}

impl<S: Scalar, const D: usize> Neg for Grad<S, D> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self {
            v: -self.v,
            g: self.g.map(|x| -x),
        }
    }
}

impl<S: Scalar, const D: usize> Mul<f64> for Grad<S, D> {
    type Output = Self;
    #[inline]
    fn mul(self, b: f64) -> Self {
        Self {
            v: self.v * b,
            g: self.g.map(|x| x * b),
        }
    }
}

impl<S: Scalar, const D: usize> Add<f64> for Grad<S, D> {
    type Output = Self;
    #[inline]
    fn add(mut self, b: f64) -> Self {
        self.v = self.v + b;
        self
    }
}

derived_operators!([S: Scalar, const D: usize] Grad<S, D>);
quotient_by_reciprocal!([S: Scalar, const D: usize] Grad<S, D>);
