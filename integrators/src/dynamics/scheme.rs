//! Time integration schemes: coefficients of one step routine.

use super::DynamicsError;

/// Coefficients of the generalised-α family with the algorithmic acceleration a carried along
/// (Arnold & Brüls 2007; theory sheet section 5):
///
/// ```text
/// (1−α_m) aₙ₊₁ + α_m aₙ = (1−α_f) q̈ₙ₊₁ + α_f q̈ₙ
/// qₙ₊₁ = qₙ + h q̇ₙ + h²[(½−β) aₙ + β aₙ₊₁],   q̇ₙ₊₁ = q̇ₙ + h[(1−γ) aₙ + γ aₙ₊₁]
/// ```
///
/// with equilibrium r(tₙ₊₁, qₙ₊₁, q̇ₙ₊₁, q̈ₙ₊₁) = 0 enforced exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme {
    /// Name for output.
    pub name: &'static str,
    /// α_m: weight of the old algorithmic acceleration.
    pub alpha_m: f64,
    /// α_f: weight of the old acceleration.
    pub alpha_f: f64,
    /// β of Newmark's coordinates.
    pub beta: f64,
    /// γ of Newmark's velocities.
    pub gamma: f64,
}

impl Default for Scheme {
    /// The trapezoidal rule: Newmark(1/4, 1/2).
    fn default() -> Self {
        Self {
            name: "Newmark",
            alpha_m: 0.0,
            alpha_f: 0.0,
            beta: 0.25,
            gamma: 0.5,
        }
    }
}

impl Scheme {
    /// Newmark(β, γ): α_m = α_f = 0, a = q̈ (Newmark 1959). β = 1/4, γ = 1/2 is the trapezoidal
    /// rule; of order 2 for γ = 1/2 only.
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] unless γ ≥ 1/2 and β ≥ γ/2 (unconditionally stable), both at
    /// most 1.
    pub fn newmark(beta: f64, gamma: f64) -> Result<Self, DynamicsError> {
        within("Newmark's gamma", gamma, [0.5, 1.0])?;
        within(
            "Newmark's beta (at least gamma/2)",
            beta,
            [gamma / 2.0, 1.0],
        )?;
        let trapezoidal = Self::default();
        Ok(Self {
            beta,
            gamma,
            ..trapezoidal
        })
    }

    /// HHT(α) (Hilber, Hughes & Taylor 1977): α_m = 0, α_f = −α, γ = ½ − α, β = (1−α)²/4; the
    /// spectral radius at infinity is (1+α)/(1−α).
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] unless −1/3 ≤ α ≤ 0.
    pub fn hht(alpha: f64) -> Result<Self, DynamicsError> {
        within("alpha of HHT", alpha, [-1.0 / 3.0, 0.0])?;
        Ok(Self::optimal("HHT", 0.0, -alpha))
    }

    /// WBZ(ρ) (Wood, Bossak & Zienkiewicz 1980): α_f = 0, α_m = (ρ−1)/(ρ+1), ρ the spectral
    /// radius at infinity.
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] unless 0 ≤ ρ ≤ 1.
    pub fn wbz(rho: f64) -> Result<Self, DynamicsError> {
        within("rho of WBZ", rho, [0.0, 1.0])?;
        Ok(Self::optimal("WBZ", (rho - 1.0) / (rho + 1.0), 0.0))
    }

    /// Chung–Hulbert(ρ∞) (1993): α_m = (2ρ−1)/(ρ+1), α_f = ρ/(ρ+1), the least damping at low
    /// frequencies for a given spectral radius ρ∞ at infinity.
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] unless 0 ≤ ρ∞ ≤ 1.
    pub fn chung_hulbert(rho: f64) -> Result<Self, DynamicsError> {
        within("rho of Chung-Hulbert", rho, [0.0, 1.0])?;
        Ok(Self::optimal(
            "generalised-alpha",
            (2.0 * rho - 1.0) / (rho + 1.0),
            rho / (rho + 1.0),
        ))
    }

    /// γ of order 2 and the β that damps high frequencies best, for given α_m and α_f.
    fn optimal(name: &'static str, alpha_m: f64, alpha_f: f64) -> Self {
        let shift = alpha_f - alpha_m;
        Self {
            name,
            alpha_m,
            alpha_f,
            beta: 0.25 * (1.0 + shift).powi(2),
            gamma: 0.5 + shift,
        }
    }

    /// Order of accuracy: 2 where γ = ½ − α_m + α_f, otherwise 1.
    pub fn order(&self) -> usize {
        let second = (self.gamma - 0.5 + self.alpha_m - self.alpha_f).abs() < 1e-14;
        1 + usize::from(second)
    }

    /// Spectral radius ρ∞ at infinite frequencies: by what factor a disturbance of the velocities
    /// and accelerations of coordinates that are held in place (by infinite stiffness, or by
    /// multipliers) changes in a step.
    pub fn spectral_radius(&self) -> f64 {
        // With q held, (h q̇, h² a) is multiplied by a matrix of this trace and determinant, and q̈
        // by −α_f/(1−α_f) besides.
        let trace = 2.0 - (self.gamma + 0.5) / self.beta;
        let determinant = 1.0 - (self.gamma - 0.5) / self.beta;
        let discriminant = 0.25 * trace * trace - determinant;
        let largest = if discriminant > 0.0 {
            0.5 * trace.abs() + discriminant.sqrt()
        } else {
            determinant.abs().sqrt()
        };
        largest.max((self.alpha_f / (1.0 - self.alpha_f)).abs())
    }

    /// ∂aₙ₊₁/∂qₙ₊₁, ∂q̇ₙ₊₁/∂qₙ₊₁ and ∂q̈ₙ₊₁/∂qₙ₊₁ for steps of size h.
    pub(super) fn rates(&self, h: f64) -> [f64; 3] {
        let a = 1.0 / (self.beta * h * h);
        [
            a,
            self.gamma * h * a,
            a * (1.0 - self.alpha_m) / (1.0 - self.alpha_f),
        ]
    }

    /// Factor of h²(aₙ₊₁ − aₙ) in the local error of qₙ₊₁: β − 1/6 for Newmark (Zienkiewicz & Xie
    /// 1991), with half of α_m − α_f for the others, whose a belongs to another time.
    pub(super) fn error_factor(&self) -> f64 {
        (self.beta + 0.5 * (self.alpha_m - self.alpha_f) - 1.0 / 6.0).abs()
    }
}

fn within(name: &'static str, value: f64, [from, to]: [f64; 2]) -> Result<(), DynamicsError> {
    // Written so that a value that is not a number is refused.
    if value >= from && value <= to {
        Ok(())
    } else {
        Err(DynamicsError::Parameter {
            name,
            value,
            from,
            to,
        })
    }
}
