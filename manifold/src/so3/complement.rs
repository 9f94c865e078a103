//! The change of chart Ψ → Ψᶜ = Ψ − 2π e and its derivatives; \[M04\] Def 15, 4.1.1.
//!
//! e = Ψ/ψ, 0 < ψ < 2π. Both vectors describe the same rotation, (Ψᶜ)ᶜ = Ψ, and the vector with
//! ψ > π is exchanged for one with ψ < π. At Ψ = 0 the complement does not exist and the results
//! are not finite.

use crate::scalar::Scalar;
use crate::so3::tensors::symmetric_outer;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// Ψᶜ = (1 − 2π/ψ) Ψ; \[M04\] Def 15.
#[must_use]
pub fn complement<S: Scalar>(Psi: &Vector3<S>) -> Vector3<S> {
    let psi = Psi.dot(Psi).sqrt();
    // The difference first: near ψ = 2π the quotient is then small without cancellation.
    Psi * ((psi - TAU) / psi)
}

/// B_s = D_Ψ Ψᶜ, symmetric: Ψ̇ᶜ = B_s Ψ̇; \[M04\] (187).
#[must_use]
pub fn B_s(Psi: &Vector3<f64>) -> Matrix3<f64> {
    let psi = Psi.norm();
    let e = Psi / psi;
    Matrix3::from_diagonal_element((psi - TAU) / psi) + e * e.transpose() * (TAU / psi)
}

/// (e·a) I + a⊗ₛe − 3 (e·a) e⊗e: −ψ² times the derivative of (I − e⊗e)/ψ along a.
fn bend(a: &Vector3<f64>, e: &Vector3<f64>) -> Matrix3<f64> {
    let u = e.dot(a);
    Matrix3::from_diagonal_element(u) + symmetric_outer(a, e) - e * e.transpose() * (3.0 * u)
}

/// Ḃ_s, symmetric: Ψ̈ᶜ = B_s Ψ̈ + Ḃ_s Ψ̇; \[M04\] (187).
#[must_use]
pub fn B_s_dot(Psi_dot: &Vector3<f64>, Psi: &Vector3<f64>) -> Matrix3<f64> {
    let psi = Psi.norm();
    bend(Psi_dot, &(Psi / psi)) * (TAU / (psi * psi))
}

/// B̈_s, symmetric: the time derivative of [`B_s_dot`] along Ψ(t), with
/// ė = (Ψ̇ − (e·Ψ̇) e)/ψ and ψ̇ = e·Ψ̇.
#[must_use]
pub fn B_s_ddot(
    Psi_ddot: &Vector3<f64>,
    Psi_dot: &Vector3<f64>,
    Psi: &Vector3<f64>,
) -> Matrix3<f64> {
    let psi = Psi.norm();
    let e = Psi / psi;
    let u = e.dot(Psi_dot);
    let e_dot = (Psi_dot - e * u) / psi;
    let u_turn = e_dot.dot(Psi_dot);
    // d/dt bend(Ψ̇, e) = bend(Ψ̈, e) + what ė contributes.
    let turn = Matrix3::from_diagonal_element(u_turn) + symmetric_outer(Psi_dot, &e_dot)
        - e * e.transpose() * (3.0 * u_turn)
        - symmetric_outer(&e, &e_dot) * (3.0 * u);
    (bend(Psi_ddot, &e) + turn - bend(Psi_dot, &e) * (2.0 * u / psi)) * (TAU / (psi * psi))
}

/// K_σs(f) = D_Ψ(B_sᵀ f), f fixed; symmetric; \[M04\] (191).
#[must_use]
pub fn K_sigma_s(f: &Vector3<f64>, Psi: &Vector3<f64>) -> Matrix3<f64> {
    // B_s is itself a gradient, so its derivative is symmetric in direction and operand.
    B_s_dot(f, Psi)
}
