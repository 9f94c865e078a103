//! Unit quaternions and the logarithm on both branches of the rotation vector chart.
//!
//! A rotation has two rotation vectors with ψ < 2π, Ψ and Ψᶜ = Ψ − 2π e, and two unit quaternions,
//! ±(w, v). The sign of the quaternion names the branch: (cos ψ/2, sin(ψ/2) e) has w ≥ 0 for ψ ≤ π and
//! w < 0 for π < ψ < 2π, and the two vectors of one rotation have opposite quaternions.

use crate::quotients::{half_angle, log_factor};
use crate::scalar::Scalar;
use crate::so3::isotropic;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// A quaternion w + v, scalar part first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quaternion<S> {
    /// Scalar part, cos ψ/2.
    pub w: S,
    /// Vector part, sin(ψ/2) e.
    pub v: Vector3<S>,
}

impl<S: Scalar> Quaternion<S> {
    /// The product whose rotation is R(self) R(b).
    #[inline]
    #[must_use]
    pub fn product(&self, b: &Self) -> Self {
        Self {
            w: self.w * b.w - self.v.dot(&b.v),
            v: b.v * self.w + self.v * b.w + self.v.cross(&b.v),
        }
    }

    /// The conjugate, whose rotation is Rᵀ.
    #[inline]
    #[must_use]
    pub fn conjugate(&self) -> Self {
        Self {
            w: self.w,
            v: -self.v,
        }
    }

    /// The rotation by an angle about a fixed axis of any length (not zero: nothing is finite then); 2π
    /// changes the sign, 4π is the period.
    #[must_use]
    pub fn about(axis: &Vector3<f64>, angle: S) -> Self {
        let half = angle * 0.5;
        let s = half.sin();
        let length = axis.norm();
        Self {
            w: half.cos(),
            v: axis.map(|e| s * (e / length)),
        }
    }

    /// The opposite quaternion: the same rotation on the other branch.
    #[inline]
    #[must_use]
    pub fn opposite(&self) -> Self {
        Self {
            w: -self.w,
            v: -self.v,
        }
    }

    /// The rotated vector R a = a + 2 v × (w a + v × a).
    #[inline]
    #[must_use]
    pub fn rotate(&self, a: &Vector3<S>) -> Vector3<S> {
        let u = self.v.cross(&(a * self.w + self.v.cross(a)));
        a + u + u
    }

    /// Inner product; its sign tells whether two nearby rotations are on the same branch.
    #[inline]
    #[must_use]
    pub fn dot(&self, b: &Self) -> S {
        self.w * b.w + self.v.dot(&b.v)
    }

    /// The modified Rodrigues parameters tan(ψ/4) e of a unit quaternion; as large as rounding errors of v allow at w = −1.
    ///
    /// Their sign is that of the quaternion: ‖σ‖ > 1 for w < 0.
    #[inline]
    #[must_use]
    pub fn rodrigues(&self) -> Vector3<S> {
        let square = self.v.dot(&self.v);
        if self.w.re() >= 0.0 {
            self.v * (self.w + S::one()).recip()
        } else if square.re() > f64::EPSILON * f64::EPSILON {
            self.v * ((S::one() - self.w) * square.recip())
        } else {
            Vector3::x() * S::constant(2.0 / f64::EPSILON)
        }
    }

    /// The unit quaternion of modified Rodrigues parameters.
    #[inline]
    #[must_use]
    pub fn from_rodrigues(sigma: &Vector3<S>) -> Self {
        let square = sigma.dot(sigma);
        let scale = (square + S::one()).recip();
        Self {
            w: (S::one() - square) * scale,
            v: sigma * (scale + scale),
        }
    }

    /// The rotation matrix of a unit quaternion.
    #[inline]
    #[must_use]
    pub fn rotation(&self) -> Matrix3<S> {
        let two = S::constant(2.0);
        let alpha = S::one() - self.v.dot(&self.v) * 2.0;
        isotropic(alpha, self.w * 2.0, two, &self.v)
    }
}

/// The unit quaternion (cos ψ/2, sin(ψ/2)/ψ Ψ) of a rotation vector, ψ < 2π.
#[must_use]
pub fn quaternion<S: Scalar>(Psi: &Vector3<S>) -> Quaternion<S> {
    let (w, factor) = half_angle(Psi.dot(Psi));
    Quaternion { w, v: Psi * factor }
}

/// The rotation vector of a unit quaternion: ψ ≤ π for w ≥ 0, π < ψ < 2π for w < 0; not finite at
/// w = −1 (ψ = 2π).
///
/// As a function of w alone the factor ψ/sin(ψ/2) loses digits when w → −1, where its pole lies;
/// there the opposite quaternion has a good logarithm, −L(−w) v, and Ψ is its complement.
#[must_use]
pub fn log_quaternion<S: Scalar>(q: &Quaternion<S>) -> Vector3<S> {
    if q.w.re() >= 0.0 {
        q.v * log_factor(q.w)
    } else {
        let pole = q.v.dot(&q.v).sqrt().recip() * TAU;
        q.v * (pole - log_factor(-q.w))
    }
}
