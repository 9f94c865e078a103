//! Value and two time derivatives.

use super::derivative;
use crate::scalar::{MAX_ORDER, Scalar};
use std::ops::{Add, Mul, Neg, Sub};

/// A value with its first and second derivative along one parameter: two orders more than `S`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taylor<S> {
    /// Value.
    pub v: S,
    /// First derivative (not divided by factorials).
    pub d: S,
    /// Second derivative.
    pub dd: S,
}

impl<S: Scalar> Scalar for Taylor<S> {
    const ORDER: usize = {
        assert!(
            S::ORDER + 1 < MAX_ORDER,
            "jets nest to total order four: differentiate once inside a map or an energy, not twice"
        );
        S::ORDER + 2
    };

    #[inline]
    fn constant(value: f64) -> Self {
        Self {
            v: S::constant(value),
            d: S::zero(),
            dd: S::zero(),
        }
    }

    #[inline]
    fn re(&self) -> f64 {
        self.v.re()
    }

    #[inline]
    fn compose(self, f: [f64; MAX_ORDER + 1]) -> Self {
        const { assert!(Self::ORDER <= MAX_ORDER) };
        let f1 = derivative(f);
        let slope = self.v.compose(f1);
        let bend = self.v.compose(derivative(f1));
        Self {
            v: self.v.compose(f),
            d: slope * self.d,
            dd: slope * self.dd + bend * (self.d * self.d),
        }
    }
}

impl<S: Scalar> Add for Taylor<S> {
    type Output = Self;
    #[inline]
    fn add(self, b: Self) -> Self {
        Self {
            v: self.v + b.v,
            d: self.d + b.d,
            dd: self.dd + b.dd,
        }
    }
}

impl<S: Scalar> Sub for Taylor<S> {
    type Output = Self;
    #[inline]
    fn sub(self, b: Self) -> Self {
        Self {
            v: self.v - b.v,
            d: self.d - b.d,
            dd: self.dd - b.dd,
        }
    }
}

impl<S: Scalar> Mul for Taylor<S> {
    type Output = Self;
    #[inline]
    fn mul(self, b: Self) -> Self {
        Self {
            v: self.v * b.v,
            d: self.d * b.v + self.v * b.d,
            dd: self.dd * b.v + self.d * b.d * 2.0 + self.v * b.dd,
        }
    }
}

impl<S: Scalar> Neg for Taylor<S> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self {
            v: -self.v,
            d: -self.d,
            dd: -self.dd,
        }
    }
}

impl<S: Scalar> Mul<f64> for Taylor<S> {
    type Output = Self;
    #[inline]
    fn mul(self, b: f64) -> Self {
        Self {
            v: self.v * b,
            d: self.d * b,
            dd: self.dd * b,
        }
    }
}

impl<S: Scalar> Add<f64> for Taylor<S> {
    type Output = Self;
    #[inline]
    fn add(mut self, b: f64) -> Self {
        self.v = self.v + b;
        self
    }
}

derived_operators!([S: Scalar] Taylor<S>);
quotient_by_reciprocal!([S: Scalar] Taylor<S>);
