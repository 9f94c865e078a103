//! Holonomic constraints as maps x = φ(t, q): one generic function, everything else derived.
//!
//! \[M04\] chapter 4: a constraint is a map from a parameter space E^D into the embedding space
//! E^N. Because the gradient in q and the time derivative commute, one run of φ over jets along
//! the motion t + τ, q + q̇τ + ½q̈τ² gives (theory: \[M04\] (180), (183))
//!
//! ```text
//! x, ẋ, ẍ     and     B = D_q φ,  Ḃ,  B̈
//! ```
//!
//! and one run over second derivatives of f·φ gives the geometric stiffness
//! K_σ(f) = D_q(Bᵀf) = Σ fᵢ D²φᵢ.

mod abilities;
pub mod derived;
mod erased;
mod graph;
mod increment;
mod linear;
pub mod pose;

pub use abilities::{Duplicate, MapState, Reparametrization, Segments};
use erased::Erased;
pub use erased::{Order, Parametrization};
pub use erased::{write_block, write_geometric_stiffness, write_orders};
pub use graph::{MapGraph, Read};
pub use increment::Increment;
pub use linear::Linear;
pub use pose::{ToChart, ToPose};

use crate::domain::DomainError;
use crate::scalar::Scalar;

use nalgebra::{SMatrix, SVector};

/// Value and gradient of a map at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tangent<const D: usize, const N: usize> {
    /// x = φ(t, q).
    pub x: SVector<f64, N>,
    /// Kinematic operator B = D_q φ, N×D.
    pub B: SMatrix<f64, N, D>,
}

/// Kinematics of a map along a motion q(t).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kinematics<const D: usize, const N: usize> {
    /// x = φ(t, q).
    pub x: SVector<f64, N>,
    /// ẋ = B q̇ + ∂φ/∂t.
    pub x_dot: SVector<f64, N>,
    /// ẍ = B q̈ + Ḃ q̇ + d/dt ∂φ/∂t.
    pub x_ddot: SVector<f64, N>,
    /// Kinematic operator B = D_q φ, N×D.
    pub B: SMatrix<f64, N, D>,
    /// Total time derivative of B along the motion.
    pub B_dot: SMatrix<f64, N, D>,
    /// Second total time derivative of B along the motion.
    pub B_ddot: SMatrix<f64, N, D>,
}

/// A holonomic constraint x = φ(t, q) from D coordinates into N.
///
/// Only [`Map::phi`] is required. The derivatives follow from it by exact differentiation
/// ([`derived`]); a map may override any of them by a closed form, which the conformance kit
/// compares with φ. A map with a state of its own (a chart, a piece of a curve) has a [`MapState`].
pub trait Map<const D: usize, const N: usize>: Send + Sync {
    /// The constraint itself, x = φ(t, q).
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, D>) -> SVector<S, N>;

    /// Distance of q to the edge of the domain on which φ is a chart, such as
    /// [`DomainError::within`]`(1.0 - q.norm(), "the unit circle: …")`. Infinite by default.
    ///
    /// # Errors
    /// [`DomainError`] outside; such a point is rejected.
    fn domain(&self, t: f64, q: &SVector<f64, D>) -> Result<f64, DomainError> {
        let _ = (t, q);
        Ok(f64::INFINITY)
    }

    /// Whether an attached frame follows a rigid motion of all frames that the map reads: true for
    /// joints between bodies, and by default; false for maps tied to space.
    fn is_objective(&self) -> bool {
        true
    }

    /// x and B.
    fn tangent(&self, t: f64, q: &SVector<f64, D>) -> Tangent<D, N> {
        derived::tangent(self, t, q)
    }

    /// x, ẋ, ẍ, B, Ḃ and B̈ along the motion with velocity v = q̇ and acceleration a = q̈.
    fn kinematics(
        &self,
        t: f64,
        q: &SVector<f64, D>,
        v: &SVector<f64, D>,
        a: &SVector<f64, D>,
    ) -> Kinematics<D, N> {
        derived::kinematics(self, t, q, v, a)
    }

    /// Geometric stiffness K_σ(f) = D_q(Bᵀ f) for a fixed covector f in E^N; symmetric D×D.
    fn geometric_stiffness(
        &self,
        t: f64,
        q: &SVector<f64, D>,
        f: &SVector<f64, N>,
    ) -> SMatrix<f64, D, D> {
        derived::geometric_stiffness(self, t, q, f)
    }

    /// What changes in the map between evaluations: nothing by default.
    fn state(&mut self) -> Option<&mut dyn MapState> {
        None
    }

    /// This map as a [`Parametrization`] trait object.
    fn boxed(self) -> Box<dyn Parametrization>
    where
        Self: Sized + Clone + 'static,
    {
        Box::new(Erased::<Self, D, N>(self))
    }
}
