//! Rates of a rotation vector from an angular velocity and its derivative.

use super::{A_varied, C1, T_dot_psi_dot, rotation, skew, tangent, tangent_inverse};
use crate::quotients::Quotients;
use nalgebra::{Matrix3, Vector3};

/// Angular velocity that replaces the rate of a rotation vector θ, R = Rₙ R(θ).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VelocityKind {
    /// Material, Ω = T θ̇ and Ω̇ = T θ̈ + Ṫ θ̇ (\[M04\] (50)): components in the moving frame.
    Material,
    /// Spatial, in the components of Rₙ: w = Rₙᵀ ω = R(θ) Ω = Tᵀ θ̇ and ẇ = Rₙᵀ ω̇ = R(θ) Ω̇. The
    /// frame is fixed, and sums of w are sums of ω.
    Spatial,
    /// The spatial w with the material Ω̇: components in the moving frame are added to those in Rₙ
    /// without transport, which costs a scheme an order. Not a published method; it shows what
    /// transport is for.
    Mixed,
}

impl VelocityKind {
    /// Tᵀ(θ) = T(−θ): spatial velocities of θ are material ones of −θ, with the opposite sign.
    fn sign(self) -> f64 {
        match self {
            Self::Material => 1.0,
            Self::Spatial | Self::Mixed => -1.0,
        }
    }
}

/// θ̇ and θ̈ of a rotation vector θ, ψ < 2π, with given angular velocity, for equations with the
/// unknowns θ, Ω and Ω̇ instead of θ, θ̇ and θ̈.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spin {
    /// The given angular velocity.
    pub kind: VelocityKind,
    /// θ̇ = T⁻¹ Ω.
    pub theta_dot: Vector3<f64>,
    /// θ̈ = T⁻¹ (Ω̇ − Ṫ θ̇).
    pub theta_ddot: Vector3<f64>,
}

impl Spin {
    /// The rates at θ from Ω and Ω̇, w and ẇ, or w and Ω̇.
    #[must_use]
    pub fn rates(
        kind: VelocityKind,
        theta: &Vector3<f64>,
        Omega: &Vector3<f64>,
        Omega_dot: &Vector3<f64>,
    ) -> Self {
        let Omega_dot = match kind {
            VelocityKind::Mixed => rotation(theta) * Omega_dot,
            VelocityKind::Material | VelocityKind::Spatial => *Omega_dot,
        };
        let theta = theta * kind.sign();
        let T_inverse = tangent_inverse(&theta);
        let theta_dot = T_inverse * Omega;
        // Ṫ θ̇ is quadratic in θ̇, whose sign thus does not matter here.
        let rest = T_dot_psi_dot(&theta_dot, &theta, &Quotients::new(theta.norm())) * kind.sign();
        Self {
            kind,
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
    ///
    /// For the mixed kind, M e is δΩ̇ in the moving frame, so that δẇ = R(θ) (M e + Tδθ × Ω̇).
    #[must_use]
    pub fn varied(&self, [K, C, M]: [f64; 3], theta: &Vector3<f64>) -> [Matrix3<f64>; 2] {
        let given = match self.kind {
            VelocityKind::Material | VelocityKind::Spatial => Matrix3::from_diagonal_element(M),
            VelocityKind::Mixed => {
                let T = tangent(theta);
                let rest = T_dot_psi_dot(&self.theta_dot, theta, &Quotients::new(theta.norm()));
                let Omega_dot = T * self.theta_ddot + rest;
                rotation(theta) * (Matrix3::from_diagonal_element(M) - skew(&Omega_dot) * T * K)
            }
        };
        // With spatial velocities all vectors change sign, but not the derivatives.
        let sign = self.kind.sign();
        let [theta, theta_dot, theta_ddot] =
            [theta, &self.theta_dot, &self.theta_ddot].map(|x| x * sign);
        let c = Quotients::new(theta.norm());
        let T_inverse = tangent_inverse(&theta);
        let of = |numbers| A_varied(numbers, &theta_dot, &theta_ddot, &theta, &c);
        let first = Matrix3::from_diagonal_element(C) - C1(&theta_dot, &theta, &c) * K;
        let first = T_inverse * first;
        let second = given - of([K, 0.0, 0.0]) - of([0.0, 1.0, 0.0]) * first;
        [first, T_inverse * second]
    }
}
