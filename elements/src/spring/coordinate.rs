//! A spring and damper on one scalar coordinate.

use super::{SpringError, finite, not_negative};
use crate::element::{Abilities, Element, ElementEnergies, Motion, Response};
use pullback_manifold::domain::DomainError;

/// The law of a [`CoordinateSpring`]: force −k (x − x₀) − k₃ (x − x₀)³ − c ẋ.
///
/// For an angle x the units are those of a torsional spring: k and k₃ in F L, c in F L T.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CoordinateLaw {
    /// Stiffness k, of any sign.
    pub k: f64,
    /// Cubic stiffness k₃, of any sign: hardening if positive.
    pub k3: f64,
    /// Damping c ≥ 0.
    pub c: f64,
    /// Unstressed coordinate x₀.
    pub x0: f64,
}

/// A spring and damper on one scalar coordinate: torsional on a joint angle, longitudinal on a
/// slide; dim 1.
///
/// Energy ½ k (x − x₀)² + ¼ k₃ (x − x₀)⁴, dissipation c ẋ².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoordinateSpring {
    law: CoordinateLaw,
}

impl CoordinateSpring {
    /// A spring with the given law.
    ///
    /// # Errors
    /// [`SpringError`] for numbers that are not finite, negative damping, or if k, k₃ and c are all
    /// zero.
    pub fn new(law: CoordinateLaw) -> Result<Self, SpringError> {
        finite("the stiffness k", &[law.k])?;
        finite("the cubic stiffness k3", &[law.k3])?;
        finite("the coordinate x0", &[law.x0])?;
        not_negative("the damping c", law.c)?;
        if law.k == 0.0 && law.k3 == 0.0 && law.c == 0.0 {
            return Err(SpringError::Nothing);
        }
        Ok(Self { law })
    }
}

impl Element for CoordinateSpring {
    fn dim(&self) -> usize {
        1
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let CoordinateLaw { k, k3, c, x0 } = self.law;
        let x = at.x[0] - x0;
        let v = at.v.first().copied().unwrap_or(0.0);
        out.r[0] -= (k + k3 * x * x) * x + c * v;
        if let Some(K) = out.K.as_deref_mut() {
            K[0] += k + 3.0 * k3 * x * x;
        }
        if let Some(C) = out.C.as_deref_mut() {
            C[0] += c;
        }
        Ok(())
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities::of_energies(self)
    }
}

impl ElementEnergies for CoordinateSpring {
    fn energy(&self, at: &Motion<'_>) -> f64 {
        let square = (at.x[0] - self.law.x0).powi(2);
        (0.5 * self.law.k + 0.25 * self.law.k3 * square) * square
    }

    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        self.law.c * at.v.first().map_or(0.0, |v| v * v)
    }
}
