//! Accuracy of schemes for vibrations: spectral radius, algorithmic damping, period elongation and
//! overshoot over Ω = ω h.
//!
//! A step of the linear oscillator q̈ + ω² q = 0 maps (q, h q̇, h² y), with the algorithmic
//! acceleration y, linearly to the next. The amplification matrix A of this map is found by three
//! steps from unit states ([`amplification`]) with the step routine of all runs; its eigenvalues λ
//! = e^(−ξ̄ Ω̄ ± i Ω̄) give the numerical vibration (Hughes, *The Finite Element Method*, 9.1): Ω̄ = ω̄
//! h its frequency, ξ̄ its damping ratio, T̄/T − 1 = Ω/Ω̄ − 1 its period elongation. [`closed_form`]
//! and [`expansion`] are independent closed forms.

mod amplification;
mod polynomial;

pub use amplification::amplification;
pub use polynomial::{characteristic, closed_form, expansion, roots};

use crate::dynamics::{DynamicsError, Scheme};

/// Accuracy of a scheme at one Ω.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Ω = ω h.
    pub Omega: f64,
    /// Coefficients p of the characteristic polynomial λ³ + p₁ λ² + p₂ λ + p₃.
    pub polynomial: [f64; 3],
    /// Results of its eigenvalues.
    pub numbers: Numbers,
    /// Results of its first step.
    pub first_step: FirstStep,
}

/// Results of the eigenvalues.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numbers {
    /// Spectral radius, the largest |λ|.
    pub radius: f64,
    /// Algorithmic damping ratio ξ̄ = −ln|λ|/Ω̄ of the complex pair; `None` if all are real.
    pub damping: Option<f64>,
    /// Period elongation T̄/T − 1 of the complex pair; `None` if all are real.
    pub elongation: Option<f64>,
}

impl Numbers {
    /// Of the characteristic polynomial λ³ + p₁ λ² + p₂ λ + p₃.
    pub fn of(polynomial: [f64; 3], Omega: f64) -> Self {
        let roots = roots(polynomial);
        let radius = roots.iter().fold(0.0_f64, |r, root| r.max(root.norm()));
        let pair = roots.iter().find(|root| root.im > 0.0);
        Self {
            radius,
            damping: pair.map(|root| -root.norm().ln() / root.arg()),
            elongation: pair.map(|root| Omega / root.arg() - 1.0),
        }
    }
}

/// The first step from rest or from the origin, with q̈₀ from the equation of motion. Values above
/// one in magnitude are overshoot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstStep {
    /// q₁/q₀ and q̇₁/(ω q₀) from q₀ at rest.
    pub from_rest: [f64; 2],
    /// ω q₁/q̇₀ and q̇₁/q̇₀ from q̇₀ at q = 0.
    pub from_origin: [f64; 2],
}

/// Accuracy of a scheme at one Ω, by its step routine.
///
/// # Errors
/// [`DynamicsError`] of a step that fails: Ω is not positive or not finite.
pub fn accuracy(scheme: &Scheme, Omega: f64) -> Result<Accuracy, DynamicsError> {
    let A = amplification(scheme, Omega)?;
    let first = |state: [f64; 3]| {
        let end = |i: usize| (0..3).map(|j| A[i][j] * state[j]).sum::<f64>();
        [end(0), end(1) * (1.0 + Omega) / Omega]
    };
    let square = Omega * Omega;
    let polynomial = characteristic(A);
    Ok(Accuracy {
        Omega,
        polynomial,
        numbers: Numbers::of(polynomial, Omega),
        first_step: FirstStep {
            from_rest: first([1.0, 0.0, -square / (1.0 + square)]),
            from_origin: first([0.0, Omega / (1.0 + Omega), 0.0]),
        },
    })
}

/// `count` values of Ω from `from` to `to`, equally spaced in their logarithm.
pub fn logarithmic(from: f64, to: f64, count: usize) -> Vec<f64> {
    let last = count.max(2) - 1;
    let ratio = (to / from).ln();
    (0..=last)
        .map(|k| from * (ratio * k as f64 / last as f64).exp())
        .collect()
}
