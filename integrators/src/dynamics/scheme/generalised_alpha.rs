//! The generalised-α family: Newmark, HHT, WBZ and Chung & Hulbert's method.

use super::{Family, Scheme, SchemeProperties, Stage};
use crate::dynamics::DynamicsError;

/// Newmark's scheme.
pub(super) const NEWMARK: Family = Family {
    word: "newmark",
    long: "newmark",
    usage: "newmark (the trapezoidal rule), or newmark:BETA:GAMMA with gamma in [1/2, 1], beta in \
            [1/100, 1], stable at every step from gamma/2 on",
    stability: None,
    make: |numbers| match *numbers {
        [] => Some(Ok(Scheme::trapezoidal())),
        [beta, gamma] => Some(Scheme::newmark(beta, gamma)),
        _ => None,
    },
};

/// Hilber, Hughes and Taylor's.
pub(super) const HHT: Family = Family {
    word: "hht",
    long: "hht",
    usage: "hht:ALPHA with alpha in [-1/3, 0], or hht:RHO with the spectral radius in [1/2, 1]",
    stability: None,
    make: |numbers| match *numbers {
        // ρ = (1 + α)/(1 − α) at infinity; no α is a ρ.
        [rho] if rho > 0.0 => Some(
            within(
                "rho of HHT (or alpha, which is not positive)",
                rho,
                [0.5, 1.0],
            )
            .and_then(|()| Scheme::hht(((rho - 1.0) / (rho + 1.0)).max(-1.0 / 3.0)))
            // Output shows the requested word.
            .map(|scheme| Scheme {
                arguments: [Some(rho), None],
                ..scheme
            }),
        ),
        [alpha] => Some(Scheme::hht(alpha)),
        _ => None,
    },
};

/// Wood, Bossak and Zienkiewicz's.
pub(super) const WBZ: Family = Family {
    word: "wbz",
    long: "wbz",
    usage: "wbz:RHO with the spectral radius in [0, 1]",
    stability: None,
    make: |numbers| match *numbers {
        [rho] => Some(Scheme::wbz(rho)),
        _ => None,
    },
};

/// Chung and Hulbert's.
pub(super) const CHUNG_HULBERT: Family = Family {
    word: "ga",
    long: "generalised-alpha",
    usage: "ga:RHO with the spectral radius in [0, 1]",
    stability: None,
    make: |numbers| match *numbers {
        [rho] => Some(Scheme::chung_hulbert(rho)),
        _ => None,
    },
};

/// Coefficients of the generalised-α family with the algorithmic acceleration a (Arnold & Brüls
/// 2007; \[M04\] ch. 5):
///
/// ```text
/// (1−α_m) aₙ₊₁ + α_m aₙ = (1−α_f) q̈ₙ₊₁ + α_f q̈ₙ
/// qₙ₊₁ = qₙ + h q̇ₙ + h²[(½−β) aₙ + β aₙ₊₁],   q̇ₙ₊₁ = q̇ₙ + h[(1−γ) aₙ + γ aₙ₊₁]
/// ```
///
/// with equilibrium r(tₙ₊₁, qₙ₊₁, q̇ₙ₊₁, q̈ₙ₊₁) = 0 enforced exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// α_m: weight of the old algorithmic acceleration.
    pub alpha_m: f64,
    /// α_f: weight of the old acceleration.
    pub alpha_f: f64,
    /// β of Newmark's coordinates.
    pub beta: f64,
    /// γ of Newmark's velocities.
    pub gamma: f64,
}

impl Scheme {
    pub(super) fn trapezoidal() -> Self {
        Self::newmark_form("Newmark", "newmark", [None; 2], [0.0, 0.0, 0.25, 0.5])
    }

    /// Newmark(β, γ): α_m = α_f = 0, a = q̈ (Newmark 1959). β = 1/4, γ = 1/2 is the trapezoidal
    /// rule; of order 2 for γ = 1/2 only. With β < γ/2 it is stable up to Ω = (γ/2 − β)^(−1/2) (Hughes, *The
    /// Finite Element Method*, 9.1): β = 1/6 is linear acceleration, β = 1/12 Fox & Goodwin's method.
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] unless 1/2 ≤ γ ≤ 1 and 1/100 ≤ β ≤ 1.
    pub fn newmark(beta: f64, gamma: f64) -> Result<Self, DynamicsError> {
        within("Newmark's gamma", gamma, [0.5, 1.0])?;
        within("Newmark's beta", beta, [0.01, 1.0])?;
        if [beta, gamma] == [0.25, 0.5] {
            return Ok(Self::trapezoidal());
        }
        let arguments = [Some(beta), Some(gamma)];
        let numbers = [0.0, 0.0, beta, gamma];
        let mut scheme = Self::newmark_form("Newmark", "newmark", arguments, numbers);
        let lacking = 0.5 * gamma - beta;
        scheme.properties.limit = (lacking > 0.0).then(|| lacking.sqrt().recip());
        Ok(scheme)
    }

    /// HHT(α) (Hilber, Hughes & Taylor 1977): α_m = 0, α_f = −α, γ = ½ − α, β = (1−α)²/4; the
    /// spectral radius at infinity is (1+α)/(1−α).
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] unless −1/3 ≤ α ≤ 0.
    pub fn hht(alpha: f64) -> Result<Self, DynamicsError> {
        within("alpha of HHT", alpha, [-1.0 / 3.0, 0.0])?;
        Ok(Self::optimal(["HHT", "hht"], alpha, [0.0, -alpha]))
    }

    /// WBZ(ρ) (Wood, Bossak & Zienkiewicz 1980): α_f = 0, α_m = (ρ−1)/(ρ+1), ρ the spectral
    /// radius at infinity.
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] unless 0 ≤ ρ ≤ 1.
    pub fn wbz(rho: f64) -> Result<Self, DynamicsError> {
        within("rho of WBZ", rho, [0.0, 1.0])?;
        let alphas = [(rho - 1.0) / (rho + 1.0), 0.0];
        Ok(Self::optimal(["WBZ", "wbz"], rho, alphas))
    }

    /// Chung–Hulbert(ρ∞) (1993): α_m = (2ρ−1)/(ρ+1), α_f = ρ/(ρ+1), the least damping at low
    /// frequencies for a given spectral radius ρ∞ at infinity.
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] unless 0 ≤ ρ∞ ≤ 1.
    pub fn chung_hulbert(rho: f64) -> Result<Self, DynamicsError> {
        within("rho of Chung-Hulbert", rho, [0.0, 1.0])?;
        let alphas = [(2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)];
        Ok(Self::optimal(["generalised-alpha", "ga"], rho, alphas))
    }

    /// γ of order 2 and the β that damps high frequencies best, for given α_m and α_f.
    fn optimal(names: [&'static str; 2], argument: f64, [alpha_m, alpha_f]: [f64; 2]) -> Self {
        let shift = alpha_f - alpha_m;
        let numbers = [alpha_m, alpha_f, 0.25 * (1.0 + shift).powi(2), 0.5 + shift];
        Self::newmark_form(names[0], names[1], [Some(argument), None], numbers)
    }

    /// One stage: of order 2 where γ = ½ − α_m + α_f, otherwise 1.
    pub(super) fn newmark_form(
        name: &'static str,
        word: &'static str,
        arguments: [Option<f64>; 2],
        [alpha_m, alpha_f, beta, gamma]: [f64; 4],
    ) -> Self {
        let stage = Stage::new(1.0, [0.5 - beta, beta], [1.0 - gamma, gamma]);
        let second = (gamma - 0.5 + alpha_m - alpha_f).abs() < 1e-14;
        let properties = SchemeProperties {
            order: 1 + usize::from(second),
            limit: None,
            symmetric: second && alpha_m == alpha_f,
        };
        Self {
            arguments,
            alpha_m,
            alpha_f,
            ..Self::table(name, word, &[stage], properties)
        }
    }

    /// The coefficients of a scheme of the generalised-α family, the central difference (β = 0)
    /// included; `None` for schemes of another form.
    pub fn coefficients(&self) -> Option<Coefficients> {
        let [Stage { c: 1.0, q, v }] = *self.stages() else {
            return None;
        };
        let newmark = (q[0] + q[1] - 0.5).abs() < 1e-14 && (v[0] + v[1] - 1.0).abs() < 1e-14;
        newmark.then_some(Coefficients {
            alpha_m: self.alpha_m,
            alpha_f: self.alpha_f,
            beta: q[1],
            gamma: v[1],
        })
    }
}

pub(super) fn within(
    name: &'static str,
    value: f64,
    [from, to]: [f64; 2],
) -> Result<(), DynamicsError> {
    // NaN is rejected.
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
