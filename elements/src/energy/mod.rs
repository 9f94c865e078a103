//! Elements defined by their energies: one generic function each, nothing derived by hand.
//!
//! ```text
//! r = −∂U/∂x − d/dt ∂T/∂ẋ + ∂T/∂x − ∂D/∂ẋ                                  Lagrange's equations
//! K = −∂r/∂x,   C = −∂r/∂ẋ,   M = −∂r/∂ẍ                                    exact
//! ```
//!
//! with a potential energy U(t, x), a kinetic energy T(x, ẋ) and a dissipation (Rayleigh's function)
//! D(x, ẋ). With p = ∂T/∂ẋ and a dot for the derivative along (ẋ, ẍ) with both held fixed,
//!
//! ```text
//! d/dt ∂T/∂ẋ = Ṫ_v        M = T_vv        C = Ṫ_vv + T_vx − T_xv + D_vv
//! K = U_xx + Ṫ_vx − T_xx + D_vx
//! ```
//!
//! so second derivatives, and third ones along one direction, are sufficient:
//! [`Phase`](pullback_manifold::jet::Phase).
//!
//! - [`EnergyElement`] is the trait to implement, [`ByEnergy`] the resulting [`Element`];
//! - [`Sampled`] adds energies at integration points in interpolated variables, like a finite
//!   element, and much faster than in the coordinates themselves;
//! - [`Sum`] adds two elements on the same nodes.

#![allow(non_snake_case)]

mod field;
mod local;
mod sampled;
mod spring;
mod sum;

pub use field::Gravity;
pub use sampled::{EnergySample, Sampled};
pub use spring::PolynomialSpring;
pub use sum::Sum;

use crate::element::{
    Abilities, Combined, CombinedTangents, EDGE, Element, ElementEnergies, Motion, Properties,
    Response,
};
use local::Local;
use nalgebra::{SVector, Vector3};
use pullback_manifold::domain::DomainError;
use pullback_manifold::jet::Grad;
use pullback_manifold::scalar::Scalar;

/// Energies of an element with N coordinates x, generic over the number type.
///
/// Energies that are not implemented are zero; the constants then save their evaluation.
/// Coordinates are those of the element's nodes in order, six for a frame node: (d, Ψ).
///
/// ```
/// use nalgebra::SVector;
/// use pullback_conformance as check;
/// use pullback_elements::energy::EnergyElement;
/// use pullback_manifold::scalar::Scalar;
///
/// /// A hardening spring with a mass, and friction that grows with the square of its rate.
/// struct Oscillator;
///
/// impl EnergyElement<1> for Oscillator {
///     fn potential<S: Scalar>(&self, _t: S, x: &SVector<S, 1>) -> S {
///         x[0].powi(2) * (x[0].powi(2) * 0.7 + 9.81)
///     }
///     fn kinetic<S: Scalar>(&self, _x: &SVector<S, 1>, v: &SVector<S, 1>) -> S {
///         v[0] * v[0] * 0.5
///     }
///     fn dissipation<S: Scalar>(&self, _x: &SVector<S, 1>, v: &SVector<S, 1>) -> S {
///         v[0].powi(2) * (v[0].powi(2) * 0.1 + 0.3)
///     }
/// }
///
/// check::element(&Oscillator.into_element()).assert();
/// ```
pub trait EnergyElement<const N: usize>: Send + Sync {
    /// Whether [`EnergyElement::kinetic`] is nonzero; `false` saves its evaluation.
    const KINETIC: bool = true;

    /// Whether [`EnergyElement::dissipation`] is nonzero; `false` saves its evaluation.
    const DISSIPATION: bool = true;

    /// Potential energy U(t, x), unit F L.
    fn potential<S: Scalar>(&self, t: S, x: &SVector<S, N>) -> S {
        let _ = (t, x);
        S::zero()
    }

    /// Kinetic energy T(x, v), unit F L. It must exert no force at rest, so a part that does not
    /// depend on v belongs to the potential.
    fn kinetic<S: Scalar>(&self, x: &SVector<S, N>, v: &SVector<S, N>) -> S {
        let _ = (x, v);
        S::zero()
    }

    /// Dissipation D(x, v), Rayleigh's function, unit F L/T: the force is −∂D/∂v and the power lost
    /// v·∂D/∂v ≥ 0, which is 2 D if D is quadratic in v. At rest the force must be zero.
    fn dissipation<S: Scalar>(&self, x: &SVector<S, N>, v: &SVector<S, N>) -> S {
        let _ = (x, v);
        S::zero()
    }

    /// Rejects coordinates at which the functions are not smooth; accepts all by default.
    ///
    /// # Errors
    /// [`DomainError`] with the reason.
    fn domain(&self, x: &SVector<f64, N>) -> Result<(), DomainError> {
        let _ = x;
        Ok(())
    }

    /// See [`Element::properties`].
    fn properties(&self) -> Properties {
        Properties::INTERNAL
    }

    /// This element.
    fn into_element(self) -> ByEnergy<Self, N>
    where
        Self: Sized,
    {
        ByEnergy(self)
    }
}

/// The derivative of `f` at x along v: strain rates from strains, for a [`dissipation`].
///
/// [`dissipation`]: EnergyElement::dissipation
pub fn rate<S: Scalar, const N: usize, const M: usize>(
    f: impl FnOnce(&SVector<Grad<S, 1>, N>) -> SVector<Grad<S, 1>, M>,
    x: &SVector<S, N>,
    v: &SVector<S, N>,
) -> SVector<S, M> {
    let moving = SVector::<Grad<S, 1>, N>::from_fn(|i, _| Grad { v: x[i], g: [v[i]] });
    f(&moving).map(|y| y.g[0])
}

/// For [`EnergyElement::domain`]: rejects a rotation vector at the edge of its chart, ψ = 2π.
///
/// # Errors
/// [`DomainError::Beyond`].
pub fn inside_chart(Psi: &Vector3<f64>) -> Result<(), DomainError> {
    let psi = Psi.norm();
    if psi <= EDGE {
        Ok(())
    } else {
        Err(DomainError::chart(psi))
    }
}

/// The element defined by energies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ByEnergy<E, const N: usize>(pub E);

/// The entries of a slice; zeros if it is empty (in statics).
fn vector<const N: usize>(from: &[f64]) -> SVector<f64, N> {
    SVector::from_fn(|i, _| from.get(i).copied().unwrap_or(0.0))
}

impl<E: EnergyElement<N>, const N: usize> Element for ByEnergy<E, N> {
    fn dim(&self) -> usize {
        N
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let (r, mut tangents) = out.parts();
        self.add(at, r, &mut tangents)?;
        if let Some(r_t) = out.r_t.as_deref_mut() {
            let rates = local::load_rate(&self.0, at.t, &vector(at.x));
            for (r_t, rate) in r_t.iter_mut().zip(&rates) {
                *r_t += rate;
            }
        }
        Ok(())
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities {
            combined: Some(self),
            energies: Some(self),
            enforced: None,
            sections: None,
        }
    }

    fn properties(&self) -> Properties {
        self.0.properties()
    }
}

impl<E: EnergyElement<N>, const N: usize> ElementEnergies for ByEnergy<E, N> {
    fn energy(&self, at: &Motion<'_>) -> f64 {
        self.0.potential(at.t, &vector(at.x))
    }

    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        if at.v.is_empty() || !E::DISSIPATION {
            return 0.0;
        }
        local::power(&self.0, &vector(at.x), &vector(at.v))
    }
}

impl<E: EnergyElement<N>, const N: usize> Combined for ByEnergy<E, N> {
    fn add(
        &self,
        at: &Motion<'_>,
        r: &mut [f64],
        tangents: &mut CombinedTangents<'_>,
    ) -> Result<(), DomainError> {
        let x = vector::<N>(at.x);
        self.0.domain(&x)?;
        let moving = (!at.v.is_empty()).then(|| (vector::<N>(at.v), vector::<N>(at.a)));
        let wanted = tangents.iter().any(Option::is_some);
        let local = Local::new(&self.0, at.t, &x, moving.as_ref(), wanted);
        for (r, l) in r.iter_mut().zip(&local.r) {
            *r += l;
        }
        for (weights, out) in tangents.iter_mut().flatten() {
            for (out, l) in out.iter_mut().zip(local.tangent(*weights).iter()) {
                *out += l;
            }
        }
        Ok(())
    }
}
