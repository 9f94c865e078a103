//! An axial spring with a polynomial force.

use nalgebra::{SVector, Vector3};
use pullback_elements::energy::EnergyElement;
use pullback_manifold::domain::DomainError;
use pullback_manifold::scalar::Scalar;

/// A spring and damper along the line between two frame nodes, its tension a polynomial in the
/// elongation e = l − l₀ and linear in its rate; dim 12.
///
/// ```text
/// N = Σ kₙ eⁿ + c ė,  n = 1 … P        U = Σ kₙ eⁿ⁺¹/(n+1),  D = ½ c ė²
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolynomialSpring<const P: usize> {
    /// Positions of the nodes in the reference configuration, global components, L.
    pub positions: [Vector3<f64>; 2],
    /// Unstressed length l₀, L.
    pub rest_length: f64,
    /// Coefficients k₁ … k_P, F/Lⁿ.
    pub k: [f64; P],
    /// Damping c ≥ 0, F T/L.
    pub c: f64,
}

impl<const P: usize> PolynomialSpring<P> {
    /// x₂ − x₁.
    fn between<S: Scalar>(&self, x: &SVector<S, 12>) -> Vector3<S> {
        let reference = self.positions[1] - self.positions[0];
        Vector3::from_fn(|i, _| x[6 + i] - x[i] + reference[i])
    }
}

impl<const P: usize> EnergyElement<12> for PolynomialSpring<P> {
    const KINETIC: bool = false;

    fn potential<S: Scalar>(&self, _t: S, x: &SVector<S, 12>) -> S {
        let u = self.between(x);
        let e = u.dot(&u).sqrt() - self.rest_length;
        // Horner, from the highest power down.
        let terms = self.k.iter().enumerate().rev();
        terms.fold(S::zero(), |sum, (i, k)| sum * e + k / (i + 2) as f64) * e * e
    }

    fn dissipation<S: Scalar>(&self, x: &SVector<S, 12>, v: &SVector<S, 12>) -> S {
        if self.c == 0.0 {
            return S::zero();
        }
        let u = self.between(x);
        let along = Vector3::from_fn(|i, _| v[6 + i] - v[i]).dot(&u);
        along * along / u.dot(&u) * (0.5 * self.c)
    }

    fn domain(&self, x: &SVector<f64, 12>) -> Result<(), DomainError> {
        let (length, size) = (
            self.between(x).norm(),
            (self.positions[1] - self.positions[0]).norm(),
        );
        // At smaller lengths the direction is only round-off.
        if length > 1e-12 * size {
            Ok(())
        } else {
            Err(DomainError::Undefined(format!(
                "its ends coincide (length {length:.3e}): its force has no direction"
            )))
        }
    }
}
