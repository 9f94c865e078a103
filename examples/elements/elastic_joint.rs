//! A bushing between two frames.

use nalgebra::{Matrix6, SVector, Vector3};
use pullback_elements::energy::{EnergyElement, inside_chart, rate};
use pullback_manifold::domain::DomainError;
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3;

/// A bushing: springs and dampers between two frames, in the relative motion; dim 12.
///
/// ```text
/// y = (R₁ᵀ(x₂ − x₁) − u₀, log R₁ᵀR₂)        U = ½ y·K y,  D = ½ ẏ·D ẏ
/// ```
///
/// [`Bushing`](pullback_elements::spring::Bushing) is the same, derived by hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElasticJoint {
    /// u₀ from the first node to the second in the reference configuration, global components, L.
    pub u0: Vector3<f64>,
    /// Stiffness, 6×6 symmetric, first three displacements: F/L, F, F L.
    pub K: Matrix6<f64>,
    /// Damping, likewise, times T.
    pub D: Matrix6<f64>,
}

impl ElasticJoint {
    fn relative<S: Scalar>(&self, x: &SVector<S, 12>) -> SVector<S, 6> {
        let triple = |i: usize| Vector3::new(x[i], x[i + 1], x[i + 2]);
        let (first, second) = (triple(3), triple(9));
        let u0 = self.u0.map(S::constant);
        let u = so3::rotation(&first).tr_mul(&(triple(6) - triple(0) + u0)) - u0;
        let [first, second] = [first, second].map(|psi| so3::quaternion(&psi));
        let theta = so3::log_quaternion(&first.conjugate().product(&second));
        SVector::<S, 6>::new(u.x, u.y, u.z, theta.x, theta.y, theta.z)
    }
}

impl EnergyElement<12> for ElasticJoint {
    const KINETIC: bool = false;

    fn potential<S: Scalar>(&self, _t: S, x: &SVector<S, 12>) -> S {
        let y = self.relative(x);
        y.dot(&(self.K.map(S::constant) * y)) * 0.5
    }

    fn dissipation<S: Scalar>(&self, x: &SVector<S, 12>, v: &SVector<S, 12>) -> S {
        let y_dot = rate(|x| self.relative(x), x, v);
        y_dot.dot(&(self.D.map(S::constant) * y_dot)) * 0.5
    }

    fn domain(&self, x: &SVector<f64, 12>) -> Result<(), DomainError> {
        inside_chart(&self.relative(x).fixed_rows::<3>(3).into_owned())
    }
}
