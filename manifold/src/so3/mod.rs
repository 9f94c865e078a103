//! Rotation vectors: the chart ψ = ‖Ψ‖ < 2π of the rotation group; \[M04\] 2.2–2.8.
//!
//! R(Ψ) maps components of the initial frame to the spatial frame. Material quantities have
//! components in the initial frame:
//!
//! ```text
//! Ω~ = Rᵀ Ṙ,   Ω = T Ψ̇,   A = Ω̇ = T Ψ̈ + Ṫ Ψ̇,   K = T Ψ′,   δΘ = T δΨ          (118)
//! ```
//!
//! so T is the material tangent map and Tᵀ the spatial one (ω = R Ω = Tᵀ Ψ̇). R, T and Ψ~ commute.
//!
//! [`rotation`], [`tangent`] and the maps of [`mod@log`], [`complement`](mod@complement) are generic
//! over [`Scalar`] and may be differentiated at Ψ = 0; the derivative tensors C₁…C₆ and Ṫ of
//! [`tensors`] are closed forms. All quotients come from [`crate::quotients`]; a kernel that needs
//! several tensors at one Ψ computes [`crate::quotients::Quotients`] once and passes it.

pub mod complement;
pub mod log;
pub mod spin;
pub mod tensors;

pub use complement::{B_s, B_s_ddot, B_s_dot, K_sigma_s, complement};
pub use log::{Quaternion, log_quaternion, quaternion};
pub use spin::{Spin, VelocityKind};
pub use tensors::{A_varied, C1, C2, C3, C6, T_ddot, T_dot, T_dot_psi_dot, T_varied};

use crate::quotients::{InverseQuotients, TangentQuotients};
use crate::scalar::Scalar;
use nalgebra::{Matrix3, Vector3};

/// a~, the skew matrix with a~ b = a × b.
#[inline]
#[must_use]
pub fn skew<S: Scalar>(a: &Vector3<S>) -> Matrix3<S> {
    let o = S::zero();
    Matrix3::new(o, -a.z, a.y, a.z, o, -a.x, -a.y, a.x, o)
}

/// α I + β Ψ~ + γ Ψ⊗Ψ, the form of R, T, T⁻¹ and of the isotropic part of every tensor.
#[inline]
pub(crate) fn isotropic<S: Scalar>(alpha: S, beta: S, gamma: S, Psi: &Vector3<S>) -> Matrix3<S> {
    let (x, y, z) = (Psi.x, Psi.y, Psi.z);
    let (gx, gy) = (gamma * x, gamma * y);
    let (xy, xz, yz) = (gx * y, gx * z, gy * z);
    let (bx, by, bz) = (beta * x, beta * y, beta * z);
    Matrix3::new(
        alpha + gx * x,
        xy - bz,
        xz + by,
        xy + bz,
        alpha + gy * y,
        yz - bx,
        xz - by,
        yz + bx,
        alpha + gamma * z * z,
    )
}

/// R(Ψ) with given quotients; see [`rotation`].
#[inline]
#[must_use]
pub fn R<S: Scalar>(Psi: &Vector3<S>, c: &TangentQuotients<S>) -> Matrix3<S> {
    // I + sinc Ψ~ + one_minus_cos Ψ~², with Ψ~² = Ψ⊗Ψ − ψ² I.
    let alpha = S::one() - c.one_minus_cos * Psi.dot(Psi);
    isotropic(alpha, c.sinc, c.one_minus_cos, Psi)
}

/// T(Ψ) with given quotients; see [`tangent`].
#[inline]
#[must_use]
pub fn T<S: Scalar>(Psi: &Vector3<S>, c: &TangentQuotients<S>) -> Matrix3<S> {
    isotropic(c.sinc, -c.one_minus_cos, c.psi_minus_sin, Psi)
}

/// T⁻¹(Ψ) with given quotients; see [`tangent_inverse`].
#[inline]
#[must_use]
pub fn T_inverse(Psi: &Vector3<f64>, a: &InverseQuotients) -> Matrix3<f64> {
    isotropic(a.g, 0.5, a.a3, Psi)
}

/// R(Ψ) a with given quotients, without forming R: cheaper where numbers carry many derivatives.
///
/// Rᵀ a is `turned` by −Ψ.
#[inline]
#[must_use]
pub fn turned<S: Scalar>(Psi: &Vector3<S>, a: &Vector3<S>, c: &TangentQuotients<S>) -> Vector3<S> {
    let once = Psi.cross(a);
    let twice = Psi.cross(&once);
    Vector3::from_fn(|i, _| a[i] + c.sinc * once[i] + c.one_minus_cos * twice[i])
}

/// T(Ψ) a with given quotients, without forming T; see [`turned`].
#[inline]
#[must_use]
pub fn spun<S: Scalar>(Psi: &Vector3<S>, a: &Vector3<S>, c: &TangentQuotients<S>) -> Vector3<S> {
    let across = Psi.cross(a);
    let along = c.psi_minus_sin * Psi.dot(a);
    Vector3::from_fn(|i, _| c.sinc * a[i] - c.one_minus_cos * across[i] + along * Psi[i])
}

/// R(Ψ), 3×3: the rotation by ψ about Ψ, initial to spatial components; \[M04\] Def 14.
#[must_use]
pub fn rotation<S: Scalar>(Psi: &Vector3<S>) -> Matrix3<S> {
    R(Psi, &TangentQuotients::new(Psi.dot(Psi)))
}

/// T(Ψ), 3×3: δΘ = T δΨ with δΘ~ = Rᵀ δR material; \[M04\] (21). R T = Tᵀ (38).
#[must_use]
pub fn tangent<S: Scalar>(Psi: &Vector3<S>) -> Matrix3<S> {
    T(Psi, &TangentQuotients::new(Psi.dot(Psi)))
}

/// T⁻¹(Ψ), 3×3: δΨ = T⁻¹ δΘ; unbounded as ψ → 2π; \[M04\] (65).
#[must_use]
pub fn tangent_inverse(Psi: &Vector3<f64>) -> Matrix3<f64> {
    T_inverse(Psi, &InverseQuotients::new(Psi.norm()))
}
