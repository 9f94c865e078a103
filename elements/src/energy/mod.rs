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
//! - [`EnergyElement`] is the trait to implement, [`ByEnergy`] the resulting
//!   [`Element`](crate::element::Element);
//! - with [`EnergySample`] it is a sum of energies at integration points in interpolated variables, like a
//!   finite element, and much faster than in the coordinates themselves.

mod by_energy;
mod local;

pub use by_energy::{ByEnergy, EnergySample};

use crate::element::Properties;
use nalgebra::{SMatrix, SVector, Vector3};
use pullback_manifold::domain::{CHART_EDGE, DomainError, LARGEST_ANGLE};
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

    /// Potential energy U(t, x), unit F L, smooth in t: a function with kinks in time is for an
    /// [`Element`](crate::element::Element) that names them. An element whose energy depends on t is declared a load, as it
    /// supplies work: otherwise the balance of energy takes that for an error.
    fn potential<S: Scalar>(&self, t: S, x: &SVector<S, N>) -> S {
        let _ = (t, x);
        S::zero()
    }

    /// Kinetic energy T(x, v), unit F L, quadratic in v but for a part linear in it: energies and momenta of a model follow from
    /// M. It must exert no force at rest, so a part that does not depend on v belongs to the potential.
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

    /// See [`Element::properties`](crate::element::Element::properties).
    fn properties(&self) -> Properties {
        Properties::INTERNAL
    }

    /// This element.
    fn into_element(self) -> ByEnergy<N>
    where
        Self: Sized + 'static,
    {
        let all = SMatrix::identity();
        ByEnergy::new([EnergySample::new(self, 1.0, SVector::zeros(), &all)])
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
    DomainError::within(LARGEST_ANGLE - Psi.norm(), CHART_EDGE)?;
    Ok(())
}
