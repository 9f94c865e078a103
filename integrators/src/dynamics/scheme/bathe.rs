//! Bathe's composite scheme: the trapezoidal rule, then three-point backward differences.

use super::generalised_alpha::within;
use super::{Family, Scheme, SchemeProperties, Stage};
use crate::dynamics::DynamicsError;
use std::f64::consts::SQRT_2;

impl Scheme {
    /// Bathe's composite scheme (Bathe & Baig 2005, Bathe & Noh 2012): the trapezoidal rule up to
    /// tₙ + γ h, from there to tₙ₊₁ the differences
    ///
    /// ```text
    /// q̇ₙ₊₁ = c₁ qₙ + c₂ q_γ + c₃ qₙ₊₁,   q̈ₙ₊₁ = c₁ q̇ₙ + c₂ q̇_γ + c₃ q̇ₙ₊₁
    /// c₁ = (1−γ)/(γh),   c₂ = −1/((1−γ)γh),   c₃ = (2−γ)/((1−γ)h)
    /// ```
    ///
    /// Of order 2 and L-stable; with γ = 2 − √2 both substeps have the same tangent for constant K.
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] unless 0.01 ≤ γ ≤ 0.99.
    pub fn bathe(gamma: f64) -> Result<Self, DynamicsError> {
        within("gamma of Bathe", gamma, [0.01, 0.99])?;
        Ok(Self::composite(gamma))
    }

    fn composite(gamma: f64) -> Self {
        // The second substep solved for q̇ₙ₊₁ − q̇ₙ, q̇_γ − q̇ₙ being h γ/2 (q̈ₙ + q̈_γ): as c₁ + c₂ +
        // c₃ = 0, it is w h (q̈ₙ + q̈_γ) + h q̈ₙ₊₁/(c₃ h).
        let last = (1.0 - gamma) / (2.0 - gamma);
        let w = 0.5 / (2.0 - gamma);
        let half = 0.5 * gamma;
        let rows = [[half, half, 0.0], [w, w, last]];
        let properties = SchemeProperties {
            order: 2,
            limit: None,
            symmetric: false,
        };
        Self {
            arguments: [Some(gamma), None],
            ..Self::table(
                "Bathe",
                "bathe",
                &Stage::runge_kutta([gamma, 1.0], rows),
                properties,
            )
        }
    }
}

/// Its entry in the list of schemes.
pub(super) const BATHE: Family = Family {
    word: "bathe",
    long: "bathe",
    usage: "bathe (gamma = 2 - sqrt 2), or bathe:GAMMA, where its first substep ends, in [0.01, 0.99]",
    // Its published formulas for q̇ = λq, h = 1: z q_γ by the trapezoidal rule, z qₙ₊₁ = c₁ + c₂ q_γ
    // + c₃ qₙ₊₁.
    stability: Some(|scheme, z| {
        let gamma = scheme.stages()[0].c;
        let middle = (1.0 + z * (0.5 * gamma)) / (1.0 - z * (0.5 * gamma));
        let [c1, c2, c3] = [
            (1.0 - gamma) / gamma,
            -1.0 / ((1.0 - gamma) * gamma),
            (2.0 - gamma) / (1.0 - gamma),
        ];
        (c1 + c2 * middle) / (z - c3)
    }),
    make: |numbers| match *numbers {
        [] => Some(Ok(Scheme {
            arguments: [None; 2],
            ..Scheme::composite(2.0 - SQRT_2)
        })),
        [gamma] => Some(Scheme::bathe(gamma)),
        _ => None,
    },
};
