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

/// Coordinates of a map in a new chart of their own: what [`Map::reparametrize`] hands back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reparametrized<const D: usize> {
    /// The new coordinates of the same configuration.
    pub q: SVector<f64, D>,
    /// Their velocities.
    pub v: SVector<f64, D>,
    /// Derivative of the new coordinates by the old ones, D×D.
    pub B: SMatrix<f64, D, D>,
    /// Accelerations change by a ↦ B a + c; c holds what comes from velocities and time.
    pub c: SVector<f64, D>,
}

/// Coordinates and velocities of a map, (q, q̇).
pub type Motion<'a, const D: usize> = [&'a SVector<f64, D>; 2];

/// A holonomic constraint x = φ(t, q) from D coordinates into N.
///
/// Only [`Map::phi`] has to be written. The other methods follow from it by exact
/// differentiation ([`derived`]); a map may replace any of them by a closed form, and
/// [`crate::check::map`] then compares the two.
pub trait Map<const D: usize, const N: usize>: Send + Sync {
    /// The constraint itself, x = φ(t, q).
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, D>) -> SVector<S, N>;

    /// Distance of q to the edge of the domain on which φ is a chart; a point with a margin ≤ 0
    /// is refused by whoever evaluates the map. Infinite by default.
    fn margin(&self, t: f64, q: &SVector<f64, D>) -> f64 {
        let _ = (t, q);
        f64::INFINITY
    }

    /// What lies at the edge where the margin ends, and what to do about it, for messages.
    fn edge(&self) -> &'static str {
        CHART_EDGE
    }

    /// Changes the charts in which φ gives its values (the branch of a logarithm, the segment of a
    /// curve) where another one is better at q. Called at converged states only: within a step φ
    /// stays one smooth function. Nothing to do by default.
    fn change_charts(&mut self, t: f64, q: &SVector<f64, D>) -> ChartChanges {
        let _ = (t, q);
        ChartChanges::default()
    }

    /// Whether a frame that is attached to the map moves with a rigid motion of all frames that the map
    /// reads: true for joints between bodies, and by default; false for what is tied to space.
    fn is_objective(&self) -> bool {
        true
    }

    /// Changes the meaning of the coordinates q where other ones are better, and tells what they
    /// are now: x, ẋ and ẍ stay what they were to the last digits. Called with every converged
    /// state, and never between. Nothing to do by default; a map that does
    /// it says so by [`Map::reparametrizes`].
    fn reparametrize(
        &mut self,
        t: f64,
        q: &SVector<f64, D>,
        v: &SVector<f64, D>,
    ) -> Option<Reparametrized<D>> {
        let _ = (t, q, v);
        None
    }

    /// Whether [`Map::reparametrize`] may ever change q: nobody else can use these coordinates then.
    fn reparametrizes(&self) -> bool {
        false
    }

    /// Which spins the rates of the last three coordinates θ are at present, if they are any: Ω and
    /// Ω̇ then stand where velocities and accelerations stand. The model takes them to θ̇ and θ̈
    /// before it asks the map ([`so3::Spin`](crate::so3::Spin)); none by default.
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

    /// Why q is outside of the domain, in words that follow "joint at node a: "; nothing by
    /// default.
    fn domain_error(&self, t: f64, q: &SVector<f64, D>) -> Option<String> {
        let _ = (t, q);
        None
    }

    /// What there is to say about the map as it is now (its independent coordinates, redundant
    /// equations), for reports; nothing by default.
    fn describe(&self) -> Option<String> {
        None
    }

    /// By what time the first change to another segment ([`Map::segment`]) is overdue at the end of a
    /// step of size h between two states (q, q̇), negative before that, and that segment. An integrator
    /// ends a step there. `None` where no change lies ahead, and by default.
    fn overshoot(&self, h: f64, from: Motion<'_, D>, to: Motion<'_, D>) -> Option<(f64, usize)> {
        let _ = (h, from, to);
        None
    }

    /// The next [`Map::change_charts`] goes on to this segment, which [`Map::overshoot`] gave.
    fn enter(&mut self, segment: usize) {
        let _ = segment;
    }

    /// Which of several sets of parents φ reads at present, for a map that travels along a chain of
    /// elements; 0 for every other map.
    fn segment(&self) -> usize {
        0
    }

    /// Where φ is pieced together from several formulas (the cubics of a spline), keeps to the one
    /// that holds at (t, q), beyond the ends of its piece too; or, for `None`, to none again. The
    /// conformance kit asks for it: derivatives are compared with differences of one smooth function.
    /// Nothing to do by default, for a φ that is smooth.
    fn freeze_piece(&mut self, at: Option<(f64, &SVector<f64, D>)>) {
        let _ = at;
    }

    /// The largest residual at φ(t, q) of the equations behind the map, each over its size; none for
    /// a map that is a formula.
    fn violation(&self, t: f64, q: &SVector<f64, D>) -> Option<f64> {
        let _ = (t, q);
        None
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

    /// The same map behind the object-safe [`Parametrization`].
    fn boxed(self) -> Box<dyn Parametrization>
    where
        Self: Sized + Clone + 'static,
    {
        Box::new(Erased::<Self, D, N>(self))
    }
}
