//! A constraint enforced by stiff springs.

#![allow(non_snake_case)]

use super::{Enforced, Levels, MAX_EQUATIONS, equation, levels, rates, vectors};
use crate::element::{Element, ElementError, Motion, Properties, Response};
use nalgebra::SVector;
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
pub enum PenaltyError {
    /// Invalid stiffness.
    #[error("a penalty must be positive and finite, got {0:?}")]
    Stiffness(f64),
    /// Negative damping.
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
/// allowed. Nothing is evaluated outside the domain of h; that of [`Scaled`](super::Scaled)
/// equations ends where a loop is torn open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penalty<H, const N: usize, const M: usize> {
    h: H,
    stiffness: PenaltyStiffness,
    names: &'static [&'static str],
}

impl<H: Map<N, M>, const N: usize, const M: usize> Penalty<H, N, M> {
    /// Enforces the given equations; [`Scaled`](super::Scaled) gives them comparable sizes.
    ///
    /// # Errors
    /// [`PenaltyError`].
    pub fn new(h: H, stiffness: PenaltyStiffness) -> Result<Self, PenaltyError> {
        const { assert!(M <= MAX_EQUATIONS, "too many equations") };
        let PenaltyStiffness { p, tau } = stiffness;
        if !(p > 0.0 && p.is_finite()) {
            return Err(PenaltyError::Stiffness(p));
        }
        if !(tau >= 0.0 && tau.is_finite()) {
            return Err(PenaltyError::Damping(tau));
        }
        Ok(Self {
            h,
            stiffness,
            names: &[],
        })
    }

    /// Names the equations, for messages.
    #[must_use]
    pub fn named(self, names: &'static [&'static str]) -> Self {
        Self { names, ..self }
    }

    /// ḣ at a motion; zero at rest.
    fn rate(&self, at: &Motion<'_>) -> SVector<f64, M> {
        if self.stiffness.tau == 0.0 || at.v.is_empty() {
            return SVector::zeros();
        }
        let [x, v, a] = vectors::<N>(at);
        self.h.kinematics(at.t, &x, &v, &a).x_dot
    }
}

impl<H: Map<N, M> + 'static, const N: usize, const M: usize> Element for Penalty<H, N, M> {
    fn dim(&self) -> usize {
        N
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), ElementError> {
        let PenaltyStiffness { p, tau } = self.stiffness;
        let [x, v, a] = vectors::<N>(at);
        let margin = self.h.margin(at.t, &x);
        if margin <= 0.0 {
            let edge = self.h.edge();
            return Err(ElementError::OutsideDomain { edge, margin });
        }
        let h = self.h.tangent(at.t, &x);
        let damped = tau > 0.0 && !at.v.is_empty();
        let moving = damped.then(|| self.h.kinematics(at.t, &x, &v, &a));
        let mut mu = h.x * p;
        if let Some(k) = &moving {
            mu += k.x_dot * (p * tau);
        }
        let force = h.B.tr_mul(&mu);
        for (r, f) in out.r.iter_mut().zip(force.iter()) {
            *r -= f;
        }
        if let Some(K) = &mut out.K {
            let mut rate = h.B * p;
            if let Some(k) = &moving {
                rate += k.B_dot * (p * tau);
            }
            let all = h.B.tr_mul(&rate) + self.h.geometric_stiffness(at.t, &x, &mu);
            for (K, k) in K.iter_mut().zip(all.iter()) {
                *K += k;
            }
        }
        if let (Some(C), true) = (&mut out.C, damped) {
            let all = h.B.tr_mul(&h.B) * (p * tau);
            for (C, c) in C.iter_mut().zip(all.iter()) {
                *C += c;
            }
        }
        if let Some(r_t) = &mut out.r_t {
            // Along t alone, at rest.
            let still = SVector::zeros();
            let k = self.h.kinematics(at.t, &x, &still, &still);
            let force = h.B.tr_mul(&(k.x_dot * p)) + k.B_dot.tr_mul(&mu);
            for (r, f) in r_t.iter_mut().zip(force.iter()) {
                *r -= f;
            }
        }
        Ok(())
    }

    fn energy(&self, at: &Motion<'_>) -> f64 {
        let [x, ..] = vectors::<N>(at);
        0.5 * self.stiffness.p * self.h.phi(at.t, &x).norm_squared()
    }

    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        self.stiffness.p * self.stiffness.tau * self.rate(at).norm_squared()
    }

    fn enforced(&self) -> Option<&dyn Enforced> {
        Some(self)
    }

    fn properties(&self) -> Properties {
        Properties {
            objective: self.h.is_objective(),
            ..Properties::INTERNAL
        }
    }
}

impl<H: Map<N, M>, const N: usize, const M: usize> Enforced for Penalty<H, N, M> {
    fn dims(&self) -> (usize, usize) {
        (N, M)
    }

    fn levels(&self, at: &Motion<'_>) -> Levels {
        levels(&self.h, at)
    }

    fn residual(&self, at: &Motion<'_>, h: &mut [f64]) {
        let [x, ..] = vectors::<N>(at);
        h.copy_from_slice(self.h.phi(at.t, &x).as_slice());
    }

    fn rates(&self, at: &Motion<'_>, h_dot: &mut [f64]) {
        rates(&self.h, at, h_dot);
    }

    fn equation(&self, i: usize) -> String {
        equation(self.names, i)
    }

    fn penalty(&self) -> Option<f64> {
        Some(self.stiffness.p)
    }
}
