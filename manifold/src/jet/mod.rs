//! Exact forward derivatives: small number types over which a [`Scalar`](crate::scalar::Scalar)
//! function is run.
//!
//! | type | carries | serves |
//! |---|---|---|
//! | [`Moving`] | value and two time derivatives, and the gradients of the three | B, Ḃ, B̈ |
//! | [`Grad`] | value and gradient in D variables | B = D_q φ |
//! | [`Taylor`] | value, first and second time derivative | ẋ, ẍ along a motion |
//! | [`Hess`] | value, gradient, Hessian | K_σ(f) = D_q²(f·φ) |
//! | [`Phase`] | value, gradient, Hessian in coordinates and velocities, along a motion | an energy's force and K, C, M |
//! | [`Trace`] | value, and in which variables it is not affine | where K_σ may differ from zero |
//!
//! The library evaluates maps and energies over all but the last. `Grad<S, 1>` also serves inside a
//! map or energy: over any of these types S it differentiates once more, up to [`MAX_ORDER`] in
//! all. Deeper nests are rejected at build time (not by `cargo check`).
//!
//! `Grad` and `Taylor` nest: `Taylor<Grad<f64, D>>` equals `Moving<D>`, only slower. The example
//! `jet_speed` measures them against the num-dual crate, the reference of their tests, and fails if
//! they are not clearly faster. For a rigid link and a revolute joint num-dual took 1.3 to 2.0
//! times as long for B, Ḃ, B̈, 4.1 to 9.0 times for K_σ, and 3.0 to 5.4 times for all of them.

use crate::scalar::MAX_ORDER;

/// Operators derived from those of two jets and of a jet and a number.
macro_rules! derived_operators {
    ([$($generics:tt)*] $type:ty) => {
        impl<$($generics)*> std::ops::Div<f64> for $type {
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
        impl<$($generics)*> std::ops::AddAssign for $type {
            #[inline]
            fn add_assign(&mut self, b: Self) {
                *self = *self + b;
            }
        }
        impl<$($generics)*> std::ops::SubAssign for $type {
            #[inline]
            fn sub_assign(&mut self, b: Self) {
                *self = *self - b;
            }
        }
        impl<$($generics)*> std::ops::MulAssign for $type {
            #[inline]
            fn mul_assign(&mut self, b: Self) {
                *self = *self * b;
            }
        }
        impl<$($generics)*> num_traits::Zero for $type {
            #[inline]
            fn zero() -> Self {
                Self::constant(0.0)
            }
            fn is_zero(&self) -> bool {
                *self == Self::zero()
            }
        }
        impl<$($generics)*> num_traits::One for $type {
            #[inline]
            fn one() -> Self {
                Self::constant(1.0)
            }
        }
    };
}

/// Division as a product with the reciprocal.
macro_rules! quotient_by_reciprocal {
    ([$($generics:tt)*] $type:ty) => {
        impl<$($generics)*> std::ops::Div for $type {
            type Output = Self;
            #[inline]
            #[allow(clippy::suspicious_arithmetic_impl, reason = "1/b has its own chain rule")]
            fn div(self, b: Self) -> Self {
                self * b.recip()
            }
        }
    };
}

mod grad;
mod hess;
mod moving;
mod phase;
mod taylor;
mod trace;

pub use grad::Grad;
pub use hess::Hess;
pub use moving::Moving;
pub use phase::Phase;
pub use taylor::Taylor;
pub use trace::Trace;

/// Shifts derivatives by one order: those of f′ from those of f.
#[inline]
fn derivative(f: [f64; MAX_ORDER + 1]) -> [f64; MAX_ORDER + 1] {
    [f[1], f[2], f[3], f[4], 0.0]
}
