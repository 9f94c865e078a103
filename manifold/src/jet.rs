//! Exact forward derivatives: three small number types over which a [`Scalar`] function is run.
//!
//! | type | carries | serves |
//! |---|---|---|
//! | [`Grad`] | value and gradient in D variables | B = D_q φ |
//! | [`Taylor`] | value, first and second time derivative | ẋ, ẍ along a motion |
//! | [`Hess`] | value, gradient, Hessian | K_σ(f) = D_q²(f·φ) |
//!
//! They nest: `Taylor<Grad<f64, D>>` gives B, Ḃ and B̈ in one evaluation.

use crate::scalar::{MAX_ORDER, Scalar};
use num_traits::{One, Zero};
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// A value with its gradient in `D` variables: total order one more than `S`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grad<S, const D: usize> {
    /// Value.
    pub v: S,
    /// Partial derivatives.
    pub g: [S; D],
}

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

impl<S: Scalar, const D: usize> Grad<S, D> {
    /// The independent variable number `i`.
    #[inline]
    pub fn variable(v: S, i: usize) -> Self {
        let mut g = [S::zero(); D];
        g[i] = S::one();
        Self { v, g }
    }
}

impl<const D: usize> Hess<D> {
    /// The independent variable number `i`.
    #[inline]
    pub fn variable(v: f64, i: usize) -> Self {
        let mut g = [0.0; D];
        g[i] = 1.0;
        Self {
            v,
            g,
            h: [[0.0; D]; D],
        }
    }
}

/// Shifts derivatives by one order: those of f′ from those of f.
#[inline]
fn derivative(f: [f64; MAX_ORDER + 1]) -> [f64; MAX_ORDER + 1] {
    [f[1], f[2], f[3], 0.0]
}

impl<S: Scalar, const D: usize> Scalar for Grad<S, D> {
    const ORDER: usize = {
        assert!(S::ORDER < MAX_ORDER, "jets nest to total order three");
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

impl<S: Scalar> Scalar for Taylor<S> {
    const ORDER: usize = {
        assert!(S::ORDER + 1 < MAX_ORDER, "jets nest to total order three");
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
        let mut out = self;
        out.v = f[0];
        for i in 0..D {
            let bend = f[2] * self.g[i];
            for j in 0..=i {
                out.h[i][j] = f[1] * self.h[i][j] + bend * self.g[j];
            }
            out.g[i] = f[1] * self.g[i];
        }
        out
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

impl<const D: usize> Hess<D> {
    /// Entry by entry combination a·self + b·other.
    #[inline]
    fn combine(mut self, a: f64, b: f64, other: &Self) -> Self {
        self.v = a * self.v + b * other.v;
        for i in 0..D {
            self.g[i] = a * self.g[i] + b * other.g[i];
            for j in 0..=i {
                self.h[i][j] = a * self.h[i][j] + b * other.h[i][j];
            }
        }
        self
    }
}

impl<const D: usize> Add for Hess<D> {
    type Output = Self;
    #[inline]
    fn add(self, b: Self) -> Self {
        self.combine(1.0, 1.0, &b)
    }
}

impl<const D: usize> Sub for Hess<D> {
    type Output = Self;
    #[inline]
    fn sub(self, b: Self) -> Self {
        self.combine(1.0, -1.0, &b)
    }
}

impl<const D: usize> Mul for Hess<D> {
    type Output = Self;
    #[inline]
    fn mul(self, b: Self) -> Self {
        let mut out = self.combine(b.v, self.v, &b);
        for i in 0..D {
            for j in 0..=i {
                out.h[i][j] += self.g[i] * b.g[j] + self.g[j] * b.g[i];
            }
        }
        out.v = self.v * b.v;
        out
    }
}

impl<const D: usize> Neg for Hess<D> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl<const D: usize> Mul<f64> for Hess<D> {
    type Output = Self;
    #[inline]
    fn mul(mut self, b: f64) -> Self {
        self.v *= b;
        for i in 0..D {
            self.g[i] *= b;
            for j in 0..=i {
                self.h[i][j] *= b;
            }
        }
        self
    }
}

impl<const D: usize> Add<f64> for Hess<D> {
    type Output = Self;
    #[inline]
    fn add(mut self, b: f64) -> Self {
        self.v += b;
        self
    }
}

/// Operators that follow from the ones above.
macro_rules! derived_operators {
    ([$($generics:tt)*] $type:ty) => {
        impl<$($generics)*> Div for $type {
            type Output = Self;
            #[inline]
            #[allow(clippy::suspicious_arithmetic_impl, reason = "1/b has its own chain rule")]
            fn div(self, b: Self) -> Self {
                self * b.recip()
            }
        }
        impl<$($generics)*> Div<f64> for $type {
            type Output = Self;
            #[inline]
            fn div(self, b: f64) -> Self {
                self * (1.0 / b)
            }
        }
        impl<$($generics)*> Sub<f64> for $type {
            type Output = Self;
            #[inline]
            fn sub(self, b: f64) -> Self {
                self + (-b)
            }
        }
        impl<$($generics)*> AddAssign for $type {
            #[inline]
            fn add_assign(&mut self, b: Self) {
                *self = *self + b;
            }
        }
        impl<$($generics)*> SubAssign for $type {
            #[inline]
            fn sub_assign(&mut self, b: Self) {
                *self = *self - b;
            }
        }
        impl<$($generics)*> MulAssign for $type {
            #[inline]
            fn mul_assign(&mut self, b: Self) {
                *self = *self * b;
            }
        }
        impl<$($generics)*> Zero for $type {
            #[inline]
            fn zero() -> Self {
                Self::constant(0.0)
            }
            fn is_zero(&self) -> bool {
                *self == Self::zero()
            }
        }
        impl<$($generics)*> One for $type {
            #[inline]
            fn one() -> Self {
                Self::constant(1.0)
            }
        }
    };
}

derived_operators!([S: Scalar, const D: usize] Grad<S, D>);
derived_operators!([S: Scalar] Taylor<S>);
derived_operators!([const D: usize] Hess<D>);
