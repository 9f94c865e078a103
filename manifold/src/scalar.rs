//! The number type of maps and energies: a constraint is written once, over this trait.

use nalgebra::{ClosedAddAssign, ClosedMulAssign, ClosedSubAssign};
use num_traits::{One, Zero};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Highest total order of differentiation any [`Scalar`] may carry.
///
/// B̈ = D_q ẍ is of order three (two in time, one in q), like the exact tangent of an equation of
/// motion from a kinetic energy. The fourth order lets a map or an energy differentiate once inside
/// itself, for the normal of a cam ([`Grad`](crate::jet::Grad), docs/adding_a_joint.md).
pub const MAX_ORDER: usize = 4;

/// A real number, or a real number with exact forward derivatives.
///
/// Constraint maps φ(t, q) and energies are written once, generically over this trait; `f64`
/// gives the value and the jets of [`crate::jet`] give derivatives to round-off.
///
/// Every smooth function is one call of [`Scalar::compose`], the chain rule; the elementary
/// functions below are defaults built on it, and functions that need care at removable
/// singularities live in [`crate::quotients`].
pub trait Scalar:
    nalgebra::Scalar
    + Copy
    + Zero
    + One
    + Neg<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + ClosedAddAssign
    + ClosedSubAssign
    + ClosedMulAssign
    + Send
    + Sync
{
    /// Total order of differentiation carried: 0 for `f64`, at most [`MAX_ORDER`].
    const ORDER: usize;

    /// A constant: all derivatives are zero.
    fn constant(value: f64) -> Self;

    /// The value without its derivatives.
    fn re(&self) -> f64;

    /// The chain rule: f(self), given `f`, f′, f″, f‴, f⁗ at `self.re()`.
    ///
    /// Entries beyond [`Scalar::ORDER`] are never read and may be zero.
    #[must_use]
    fn compose(self, f: [f64; MAX_ORDER + 1]) -> Self;

    /// Reciprocal 1/x.
    #[must_use]
    fn recip(self) -> Self {
        let u = 1.0 / self.re();
        let u2 = u * u;
        self.compose([u, -u2, 2.0 * u2 * u, -6.0 * u2 * u2, 24.0 * u2 * u2 * u])
    }

    /// Square root; not differentiable at 0 (write norms as functions of the squared norm).
    #[must_use]
    fn sqrt(self) -> Self {
        let x = self.re();
        let (s, u) = (x.sqrt(), 1.0 / x);
        let d1 = 0.5 * s * u;
        let d2 = -0.5 * d1 * u;
        let d3 = -1.5 * d2 * u;
        self.compose([s, d1, d2, d3, -2.5 * d3 * u])
    }

    /// Sine.
    #[must_use]
    fn sin(self) -> Self {
        let (s, c) = self.re().sin_cos();
        self.compose([s, c, -s, -c, s])
    }

    /// Cosine.
    #[must_use]
    fn cos(self) -> Self {
        let (s, c) = self.re().sin_cos();
        self.compose([c, -s, -c, s, c])
    }

    /// Tangent.
    #[must_use]
    fn tan(self) -> Self {
        self.sin() / self.cos()
    }

    /// Exponential function.
    #[must_use]
    fn exp(self) -> Self {
        self.compose([self.re().exp(); MAX_ORDER + 1])
    }

    /// Natural logarithm.
    #[must_use]
    fn ln(self) -> Self {
        let x = self.re();
        let u = 1.0 / x;
        let u2 = u * u;
        self.compose([x.ln(), u, -u2, 2.0 * u2 * u, -6.0 * u2 * u2])
    }

    /// Arc tangent.
    #[must_use]
    fn atan(self) -> Self {
        let x = self.re();
        let u = 1.0 / (1.0 + x * x);
        self.compose([
            x.atan(),
            u,
            -2.0 * x * u * u,
            (6.0 * x * x - 2.0) * u * u * u,
            24.0 * x * (1.0 - x * x) * (u * u) * (u * u),
        ])
    }

    /// Four-quadrant arc tangent of `self`/`x`, smooth everywhere but at the origin.
    #[must_use]
    fn atan2(self, x: Self) -> Self {
        // Rotate by the (constant) real angle first: the rest is an arc tangent near zero.
        let angle = self.re().atan2(x.re());
        let (s, c) = angle.sin_cos();
        let along = x * c + self * s;
        let across = self * c - x * s;
        (across / along).atan() + angle
    }

    /// Integer power.
    #[must_use]
    fn powi(self, n: i32) -> Self {
        let x = self.re();
        let k = f64::from(n);
        let term = |order: i32, factor: f64| {
            if factor == 0.0 {
                0.0
            } else {
                factor * x.powi(n - order)
            }
        };
        self.compose([
            x.powi(n),
            term(1, k),
            term(2, k * (k - 1.0)),
            term(3, k * (k - 1.0) * (k - 2.0)),
            term(4, k * (k - 1.0) * (k - 2.0) * (k - 3.0)),
        ])
    }
}

impl Scalar for f64 {
    const ORDER: usize = 0;

    #[inline]
    fn constant(value: f64) -> Self {
        value
    }

    #[inline]
    fn re(&self) -> f64 {
        *self
    }

    #[inline]
    fn compose(self, f: [f64; MAX_ORDER + 1]) -> Self {
        f[0]
    }
}
