//! Derivatives of T and its relatives in closed form; \[M04\] (44)–(53), (63), (68).
//!
//! Arguments come in the order of the thesis: the vector acted upon, then Ψ, then the quotients at
//! ψ = ‖Ψ‖. Every tensor is 3×3, with the direction of differentiation in the column.

use crate::quotients::{InverseQuotients, Quotients};
use crate::so3::{isotropic, skew};
use nalgebra::{Matrix3, Vector3};

/// a⊗b = a bᵀ.
#[inline]
fn outer(a: &Vector3<f64>, b: &Vector3<f64>) -> Matrix3<f64> {
    a * b.transpose()
}

/// a⊗ₛb = a bᵀ + b aᵀ.
#[inline]
pub(crate) fn symmetric_outer(a: &Vector3<f64>, b: &Vector3<f64>) -> Matrix3<f64> {
    let A = outer(a, b);
    A + A.transpose()
}

/// α I + a~.
#[inline]
fn turning(alpha: f64, a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(alpha, -a.z, a.y, a.z, alpha, -a.x, -a.y, a.x, alpha)
}

/// D_Ψ(T V) for sign = 1 and D_Ψ(Tᵀ V) for sign = −1: transposing T turns Ψ into −Ψ in its skew part.
#[inline]
fn C12(sign: f64, V: &Vector3<f64>, Psi: &Vector3<f64>, c: &Quotients) -> Matrix3<f64> {
    let s = Psi.dot(V);
    // Everything that ends in ⊗Ψ.
    let left = V * c.c1 - Psi.cross(V) * (sign * c.c2) + Psi * (c.c3 * s);
    outer(&left, Psi) + turning(c.c5 * s, &(V * (-sign * c.c4))) + outer(&(Psi * c.c5), V)
}

/// C₁(V,Ψ) = D_Ψ(T V), V fixed; \[M04\] (44).
#[must_use]
pub fn C1(V: &Vector3<f64>, Psi: &Vector3<f64>, c: &Quotients) -> Matrix3<f64> {
    C12(1.0, V, Psi, c)
}

/// C₁(V,Ψ) d = D_Ψ(T V)·d without forming C₁.
#[inline]
#[must_use]
pub fn T_varied(
    V: &Vector3<f64>,
    d: &Vector3<f64>,
    Psi: &Vector3<f64>,
    c: &Quotients,
) -> Vector3<f64> {
    let (s, along) = (Psi.dot(V), Psi.dot(d));
    V * (c.c1 * along) - Psi.cross(V) * (c.c2 * along) + d * (c.c5 * s) - V.cross(d) * c.c4
        + Psi * (c.c3 * s * along + c.c5 * V.dot(d))
}

/// C₂(V,Ψ) = D_Ψ(Tᵀ V), V fixed; equals C₁(R V,Ψ) − Tᵀ V~ T; \[M04\] (47), (49).
#[must_use]
pub fn C2(V: &Vector3<f64>, Psi: &Vector3<f64>, c: &Quotients) -> Matrix3<f64> {
    C12(-1.0, V, Psi, c)
}

/// C₃(V,Ψ′,Ψ) = D_Ψ(C₁(Ψ′,Ψ)ᵀ V), V and Ψ′ fixed; symmetric; \[M04\] (52).
#[must_use]
pub fn C3(
    V: &Vector3<f64>,
    Psi_prime: &Vector3<f64>,
    Psi: &Vector3<f64>,
    c: &Quotients,
) -> Matrix3<f64> {
    let p = Psi_prime.dot(V);
    let q = Psi.cross(Psi_prime).dot(V);
    let (s, s_prime) = (Psi.dot(V), Psi.dot(Psi_prime));
    let r = s * s_prime;
    let alpha = c.c1 * p - c.c2 * q + c.c3 * r;
    let gamma = c.dc1 * p - c.dc2 * q + c.dc3 * r;
    let right = Psi_prime.cross(V) * -c.c2 + (Psi_prime * s + V * s_prime) * c.c3;
    isotropic(alpha, 0.0, gamma, Psi)
        + symmetric_outer(Psi, &right)
        + symmetric_outer(&(V * c.c5), Psi_prime)
}

/// Ṫ, the time derivative of T(Ψ(t)); \[M04\] (50).
#[must_use]
pub fn T_dot(Psi_dot: &Vector3<f64>, Psi: &Vector3<f64>, c: &Quotients) -> Matrix3<f64> {
    let d = Psi.dot(Psi_dot);
    isotropic(c.c1 * d, -c.c2 * d, c.c3 * d, Psi)
        + skew(&(Psi_dot * c.c4))
        + symmetric_outer(&(Psi_dot * c.c5), Psi)
}

/// T̈, the second time derivative of T(Ψ(t)).
#[must_use]
pub fn T_ddot(
    Psi_dot: &Vector3<f64>,
    Psi_ddot: &Vector3<f64>,
    Psi: &Vector3<f64>,
    c: &Quotients,
) -> Matrix3<f64> {
    let d = Psi.dot(Psi_dot);
    let d_dot = Psi_dot.dot(Psi_dot) + Psi.dot(Psi_ddot);
    let second = |first: f64, derivative: f64| derivative * d * d + first * d_dot;
    isotropic(
        second(c.c1, c.dc1),
        -second(c.c2, c.dc2),
        second(c.c3, c.dc3),
        Psi,
    ) + skew(&(Psi_ddot * c.c4 - Psi_dot * (2.0 * c.c2 * d)))
        + symmetric_outer(&(Psi_ddot * c.c5 + Psi_dot * (2.0 * c.c3 * d)), Psi)
        + symmetric_outer(&(Psi_dot * c.c5), Psi_dot)
}

/// Ṫ Ψ̇, the part of the material angular acceleration A = T Ψ̈ + Ṫ Ψ̇ that is quadratic in Ψ̇.
#[must_use]
pub fn T_dot_psi_dot(Psi_dot: &Vector3<f64>, Psi: &Vector3<f64>, c: &Quotients) -> Vector3<f64> {
    let d = Psi.dot(Psi_dot);
    let n = Psi_dot.dot(Psi_dot);
    Psi_dot * ((c.c1 + c.c5) * d) - Psi.cross(Psi_dot) * (c.c2 * d)
        + Psi * (c.c3 * d * d + c.c5 * n)
}

/// The weighted sum K D_Ψ A + C D_Ψ̇ A + M D_Ψ̈ A of the derivatives of A = T Ψ̈ + Ṫ Ψ̇, that is
/// K (C₅(Ψ̇,Ψ) + C₁(Ψ̈,Ψ)) + C C₄(Ψ̇,Ψ) + M T, collected by right factor.
#[inline]
#[must_use]
pub fn A_varied(
    [K, C, M]: [f64; 3],
    Psi_dot: &Vector3<f64>,
    Psi_ddot: &Vector3<f64>,
    Psi: &Vector3<f64>,
    c: &Quotients,
) -> Matrix3<f64> {
    let (d, dd) = (Psi.dot(Psi_dot), Psi.dot(Psi_ddot));
    let n = Psi_dot.dot(Psi_dot);
    let (turned, turned_ddot) = (Psi.cross(Psi_dot), Psi.cross(Psi_ddot));
    let shared = Psi_dot * (c.c1 + c.c5) - turned * c.c2 + Psi * (2.0 * c.c3 * d);
    let on_psi = Psi_dot * (K * d * (c.dc1 + c.c3)) - turned * (K * d * c.dc2)
        + Psi_ddot * (K * c.c1)
        - turned_ddot * (K * c.c2)
        + shared * C
        + Psi * (K * (c.dc3 * d * d + c.c3 * (n + dd)) + M * c.c5);
    let on_psi_dot = shared * K + Psi * (2.0 * C * c.c5);
    let scalar = K * (c.c3 * d * d + c.c5 * (n + dd)) + C * (c.c1 + c.c5) * d + M * c.sinc;
    let axial = Psi_dot * (K * c.c2 * d)
        - Psi_ddot * (K * c.c4)
        - Psi * (C * c.c2 * d + M * c.one_minus_cos);
    outer(&on_psi, Psi)
        + outer(&on_psi_dot, Psi_dot)
        + outer(&(Psi * (K * c.c5)), Psi_ddot)
        + turning(scalar, &axial)
}

/// C₆(V,Ψ) = D_Ψ(T⁻ᵀ V), V fixed; \[M04\] (68).
#[must_use]
pub fn C6(V: &Vector3<f64>, Psi: &Vector3<f64>, a: &InverseQuotients) -> Matrix3<f64> {
    let s = Psi.dot(V);
    let left = V * a.a1 + Psi * (a.a2 * s);
    outer(&left, Psi) + turning(a.a3 * s, &(V * 0.5)) + outer(&(Psi * a.a3), V)
}
