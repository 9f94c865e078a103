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

#![allow(non_snake_case)]

mod composed;
pub mod derived;
mod erased;
mod increment;
mod linear;

pub use composed::Composed;
use erased::Erased;
pub use erased::{KinematicsMut, Parametrization};
pub use increment::Increment;
pub use linear::Linear;

use crate::scalar::Scalar;
use crate::so3::VelocityKind;
use crate::system::{CHART_EDGE, ChartChanges};
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

/// Coordinates of a map in a new chart, the result of [`Map::reparametrize`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reparametrized<const D: usize> {
    /// The new coordinates of the same configuration.
    pub q: SVector<f64, D>,
    /// Their velocities.
    pub v: SVector<f64, D>,
    /// Derivative of the new coordinates by the old ones, D×D.
    pub B: SMatrix<f64, D, D>,
    /// Accelerations transform by a ↦ B a + c; c collects the terms of velocity and time.
    pub c: SVector<f64, D>,
}

/// Coordinates and velocities of a map, (q, q̇).
pub type Motion<'a, const D: usize> = [&'a SVector<f64, D>; 2];

/// A holonomic constraint x = φ(t, q) from D coordinates into N.
///
/// Only [`Map::phi`] is required. The other methods follow from it by exact differentiation
/// ([`derived`]); a map may override any of them by a closed form, which the conformance kit
/// compares with φ.
pub trait Map<const D: usize, const N: usize>: Send + Sync {
    /// The constraint itself, x = φ(t, q).
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, D>) -> SVector<S, N>;

    /// Distance of q to the edge of the domain on which φ is a chart; points with a margin ≤ 0 are
    /// rejected. Infinite by default.
    fn margin(&self, t: f64, q: &SVector<f64, D>) -> f64 {
        let _ = (t, q);
        f64::INFINITY
    }

    /// Description of the limit where the margin ends, with a remedy, for messages.
    fn edge(&self) -> &'static str {
        CHART_EDGE
    }

    /// Changes the charts of the values of φ (branch of a logarithm, segment of a curve) if another
    /// one is better at q. Called at converged states only: within a step φ is one smooth function.
    /// Nothing by default.
    fn change_charts(&mut self, t: f64, q: &SVector<f64, D>) -> ChartChanges {
        let _ = (t, q);
        ChartChanges::default()
    }

    /// Whether an attached frame follows a rigid motion of all frames that the map reads: true for
    /// joints between bodies, and by default; false for maps tied to space.
    fn is_objective(&self) -> bool {
        true
    }

    /// Changes the coordinates q to better ones and returns their values; x, ẋ and ẍ stay the same
    /// to rounding. Called at every converged state, and never between. Nothing by default; a map
    /// that overrides it also overrides [`Map::reparametrizes`].
    fn reparametrize(
        &mut self,
        t: f64,
        q: &SVector<f64, D>,
        v: &SVector<f64, D>,
    ) -> Option<Reparametrized<D>> {
        let _ = (t, q, v);
        None
    }

    /// Whether [`Map::reparametrize`] may change q: no other map or element may then use these
    /// coordinates.
    fn reparametrizes(&self) -> bool {
        false
    }

    /// Kind of angular velocity that replaces the rates of the last three coordinates θ at present,
    /// if any: Ω and Ω̇ are then stored as velocities and accelerations. The model converts them to
    /// θ̇ and θ̈ before it evaluates the map ([`so3::Spin`](crate::so3::Spin)). None by default.
    fn velocity_kind(&self) -> Option<VelocityKind> {
        None
    }

    /// See [`Parametrization::save`]; nothing by default.
    fn save(&self) -> Vec<f64> {
        Vec::new()
    }

    /// See [`Parametrization::restore`].
    fn restore(&mut self, saved: &[f64]) -> bool {
        saved.is_empty()
    }

    /// Amount by which a step of size h between two states (q, q̇) overshot the first change of
    /// segment ([`Map::segment`]), in units of time, negative before it; and the new segment.
    /// Integrators end a step there. `None` if there is no change ahead, and by default.
    fn overshoot(&self, h: f64, from: Motion<'_, D>, to: Motion<'_, D>) -> Option<(f64, usize)> {
        let _ = (h, from, to);
        None
    }

    /// Makes the next [`Map::change_charts`] enter this segment, a result of [`Map::overshoot`].
    fn enter(&mut self, segment: usize) {
        let _ = segment;
    }

    /// Index of the set of parents that φ reads at present, for a map along a chain of elements; 0
    /// for every other map.
    fn segment(&self) -> usize {
        0
    }

    /// Freezes a piecewise φ (the cubics of a spline) to the piece that holds at (t, q), also
    /// beyond its ends; `None` releases it. Used by the conformance kit to compare derivatives with
    /// differences of one smooth function. Nothing by default, for a smooth φ.
    fn freeze_piece(&mut self, at: Option<(f64, &SVector<f64, D>)>) {
        let _ = at;
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

    /// This map as a [`Parametrization`] trait object.
    fn boxed(self) -> Box<dyn Parametrization>
    where
        Self: Sized + Clone + 'static,
    {
        Box::new(Erased::<Self, D, N>(self))
    }
}
