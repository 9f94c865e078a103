//! Rates of a rotation vector from the material angular velocity and its rate.

#![allow(non_snake_case)]

use super::{A_varied, C1, T_dot_psi_dot, tangent_inverse};
use crate::quotients::Quotients;
use nalgebra::{Matrix3, Vector3};

/// θ̇ and θ̈ of a rotation vector θ whose spins Ω = T θ̇ and Ω̇ = T θ̈ + Ṫ θ̇ (\[M04\] (50)) are given,
/// ψ < 2π: unknowns of an equation may be θ, Ω and Ω̇ in place of θ, θ̇ and θ̈.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spin {
    /// θ̇ = T⁻¹ Ω.
    pub theta_dot: Vector3<f64>,
    /// θ̈ = T⁻¹ (Ω̇ − Ṫ θ̇).
    pub theta_ddot: Vector3<f64>,
}

impl Spin {
    /// The rates at θ with the spins Ω and Ω̇.
    #[must_use]
    pub fn rates(theta: &Vector3<f64>, Omega: &Vector3<f64>, Omega_dot: &Vector3<f64>) -> Self {
        let T_inverse = tangent_inverse(theta);
        let theta_dot = T_inverse * Omega;
        let rest = T_dot_psi_dot(&theta_dot, theta, &Quotients::new(theta.norm()));
        Self {
            theta_dot,
            theta_ddot: T_inverse * (Omega_dot - rest),
        }
    }

    /// The derivatives of θ̇ and of θ̈ along δθ = K e, δΩ = C e, δΩ̇ = M e for fixed numbers K, C, M
    /// (3×3, acting on e), from the variation of the definitions:
    ///
    /// ```text
    /// T δθ̇ = δΩ − C₁(θ̇,θ) δθ                                                [M04] (44)
    /// T δθ̈ = δΩ̇ − (C₅(θ̇,θ) + C₁(θ̈,θ)) δθ − C₄(θ̇,θ) δθ̇                       [M04] (63)
    /// ```
    #[must_use]
    pub fn varied(&self, [K, C, M]: [f64; 3], theta: &Vector3<f64>) -> [Matrix3<f64>; 2] {
        let c = Quotients::new(theta.norm());
        let T_inverse = tangent_inverse(theta);
        let of = |numbers| A_varied(numbers, &self.theta_dot, &self.theta_ddot, theta, &c);
        let first = Matrix3::from_diagonal_element(C) - C1(&self.theta_dot, theta, &c) * K;
        let first = T_inverse * first;
        let second =
            Matrix3::from_diagonal_element(M) - of([K, 0.0, 0.0]) - of([0.0, 1.0, 0.0]) * first;
        [first, T_inverse * second]
    }
}
