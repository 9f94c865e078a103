//! Value and two time derivatives.

use super::{derivative, nested_order};
use crate::scalar::{MAX_ORDER, Scalar};

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
    const ORDER: usize = nested_order(S::ORDER, 2);

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

impl<S: Scalar> Taylor<S> {
    #[inline]
    fn plus(self, b: Self) -> Self {
        Self {
            v: self.v + b.v,
            d: self.d + b.d,
            dd: self.dd + b.dd,
        }
    }

    #[inline]
    fn minus(self, b: Self) -> Self {
        Self {
            v: self.v - b.v,
            d: self.d - b.d,
            dd: self.dd - b.dd,
        }
    }

    #[inline]
    fn times(self, b: Self) -> Self {
        Self {
            v: self.v * b.v,
            d: self.d * b.v + self.v * b.d,
            dd: self.dd * b.v + self.d * b.d * 2.0 + self.v * b.dd,
        }
    }

    #[inline]
    fn scaled(self, b: f64) -> Self {
        Self {
            v: self.v * b,
            d: self.d * b,
            dd: self.dd * b,
        }
    }

    #[inline]
    fn shifted(mut self, b: f64) -> Self {
        self.v = self.v + b;
        self
    }
}

operators!([S: Scalar] Taylor<S>);
