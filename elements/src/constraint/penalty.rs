//! A constraint enforced by stiff springs.

use super::{NamedEquations, vectors};
use crate::blocks::{add, add_block};
use crate::element::{Abilities, Element, ElementEnergies, Motion, Properties, Response};
use nalgebra::SVector;
use pullback_manifold::domain::DomainError;
use pullback_manifold::map::Map;

/// Stiffness of a penalty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PenaltyStiffness {
    /// Stiffness p > 0, in units of energy for equations without unit.
    pub p: f64,
    /// Time constant τ ≥ 0 of parallel dampers, with the forces p τ ḣ.
    pub tau: f64,
}

/// Error of a penalty.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "each message says what its variant is")]
#[non_exhaustive]
pub enum PenaltyError {
    #[error("a penalty must be positive and finite, got {0:?}")]
    Stiffness(f64),
    #[error("the damping time of a penalty must be finite and zero or positive, got {0:?}")]
    Damping(f64),
}

/// The equations h(t, x) = 0 enforced by springs and dampers, U = ½ p hᵀh and D = ½ p τ ḣᵀḣ:
///
/// ```text
/// r = −h_xᵀ μ,   μ = p (h + τ ḣ)        C = p τ h_xᵀ h_x
/// K = p h_xᵀ (h_x + τ (h_x)˙) + Σ μᵢ D²hᵢ
/// ```
///
/// The equations are violated by μ/p: errors are of order 1/p, and so are the squared periods of
/// vibrations on the springs, which a scheme without damping keeps. Redundant equations are
/// allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penalty<H, const N: usize, const M: usize> {
    equations: NamedEquations<H, N, M>,
    stiffness: PenaltyStiffness,
}

impl<H: Map<N, M>, const N: usize, const M: usize> Penalty<H, N, M> {
    /// Enforces the given equations, divided by their sizes.
    ///
    /// # Errors
    /// [`PenaltyError`].
    pub fn new(h: H, stiffness: PenaltyStiffness) -> Result<Self, PenaltyError> {
        let PenaltyStiffness { p, tau } = stiffness;
        if !(p > 0.0 && p.is_finite()) {
            return Err(PenaltyError::Stiffness(p));
        }
        if !(tau >= 0.0 && tau.is_finite()) {
            return Err(PenaltyError::Damping(tau));
        }
        Ok(Self {
            equations: NamedEquations::new(h, Some(p)),
            stiffness,
        })
    }

    /// Names the equations, for messages.
    #[must_use]
    pub fn named(mut self, names: &'static [&'static str]) -> Self {
        self.equations.names = names;
        self
    }
}

impl<H: Map<N, M> + 'static, const N: usize, const M: usize> Element for Penalty<H, N, M> {
    fn dim(&self) -> usize {
        N
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let PenaltyStiffness { p, tau } = self.stiffness;
        let [x, v, a] = vectors::<N>(at);
        self.equations.h.domain(at.t, &x)?;
        let h = self.equations.h.tangent(at.t, &x);
        let damped = tau > 0.0 && !at.v.is_empty();
        let moving = damped.then(|| self.equations.h.kinematics(at.t, &x, &v, &a));
        let mut mu = h.x * p;
        if let Some(k) = &moving {
            mu += k.x_dot * (p * tau);
        }
        add(out.r, 0, &-h.B.tr_mul(&mu));
        if let Some(K) = &mut out.K {
            let mut rate = h.B * p;
            if let Some(k) = &moving {
                rate += k.B_dot * (p * tau);
            }
            let all = h.B.tr_mul(&rate) + self.equations.h.geometric_stiffness(at.t, &x, &mu);
            add_block(K, N, 0, 0, &all);
        }
        if let (Some(C), true) = (&mut out.C, damped) {
            add_block(C, N, 0, 0, &(h.B.tr_mul(&h.B) * (p * tau)));
        }
        if let Some(r_t) = &mut out.r_t {
            // Along t alone, at rest.
            let still = SVector::zeros();
            let k = self.equations.h.kinematics(at.t, &x, &still, &still);
            let mut mu_t = k.x_dot * p;
            if damped {
                mu_t += (k.B_dot * v + k.x_ddot) * (p * tau);
            }
            add(r_t, 0, &-(h.B.tr_mul(&mu_t) + k.B_dot.tr_mul(&mu)));
        }
        Ok(())
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities {
            energies: Some(self),
            enforced: Some(&self.equations),
            ..Abilities::default()
        }
    }

    fn properties(&self) -> Properties {
        self.equations.properties()
    }
}

impl<H: Map<N, M> + 'static, const N: usize, const M: usize> ElementEnergies for Penalty<H, N, M> {
    fn energy(&self, at: &Motion<'_>) -> f64 {
        let [x, ..] = vectors::<N>(at);
        0.5 * self.stiffness.p * self.equations.h.phi(at.t, &x).norm_squared()
    }

    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        let PenaltyStiffness { p, tau } = self.stiffness;
        if tau == 0.0 || at.v.is_empty() {
            return 0.0;
        }
        let [x, v, a] = vectors::<N>(at);
        let h_dot = self.equations.h.kinematics(at.t, &x, &v, &a).x_dot;
        p * tau * h_dot.norm_squared()
    }
}
