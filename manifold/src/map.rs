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
mod increment;
mod linear;

pub use composed::Composed;
pub use increment::Increment;
pub use linear::Linear;

use crate::scalar::Scalar;
use crate::so3::Spins;
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

/// Coordinates of a map in a new chart of their own: what [`Map::rewrite`] hands back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rewritten<const D: usize> {
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

    /// Changes the charts in which φ gives its values (the sheet of a logarithm, the segment of a
    /// curve) where another one is better at q. Called at converged states only: within a step φ
    /// stays one smooth function. Nothing to do by default.
    fn change_charts(&mut self, t: f64, q: &SVector<f64, D>) -> ChartChanges {
        let _ = (t, q);
        ChartChanges::default()
    }

    /// Whether a frame that hangs on the map moves with a rigid motion of all frames that the map
    /// reads: true for joints between bodies, and by default; false for what is tied to space.
    fn is_objective(&self) -> bool {
        true
    }

    /// Changes the meaning of the coordinates q where other ones are better, and tells what they
    /// are now: x, ẋ and ẍ stay what they were to the last digits. Called with every converged
    /// state, and never between. Nothing to do by default; a map that does
    /// it says so by [`Map::rewrites`].
    fn rewrite(
        &mut self,
        t: f64,
        q: &SVector<f64, D>,
        v: &SVector<f64, D>,
    ) -> Option<Rewritten<D>> {
        let _ = (t, q, v);
        None
    }

    /// Whether [`Map::rewrite`] may ever change q: nobody else can use these coordinates then.
    fn rewrites(&self) -> bool {
        false
    }

    /// Which spins the rates of the last three coordinates θ are at present, if they are any: Ω and
    /// Ω̇ then stand where velocities and accelerations stand. The model takes them to θ̇ and θ̈
    /// before it asks the map ([`so3::Spin`](crate::so3::Spin)); none by default.
    fn spins(&self) -> Option<Spins> {
        None
    }

    /// See [`Parametrization::memory`]; nothing by default.
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }

    /// See [`Parametrization::recall`].
    fn recall(&mut self, memory: &[f64]) -> bool {
        memory.is_empty()
    }

    /// Why q is outside of the domain, in words that follow "joint at node a: "; nothing by
    /// default.
    fn trouble(&self, t: f64, q: &SVector<f64, D>) -> Option<String> {
        let _ = (t, q);
        None
    }

    /// What there is to say about the map as it is now (its independent coordinates, redundant
    /// equations), for reports; nothing by default.
    fn note(&self) -> Option<String> {
        None
    }

    /// By what time the first change to another segment ([`Map::segment`]) is overdue at the end of a
    /// step of size h between two states (q, q̇), negative before that, and that segment. An integrator
    /// ends a step there. `None` where no change lies ahead, and by default.
    fn overdue(&self, h: f64, from: Motion<'_, D>, to: Motion<'_, D>) -> Option<(f64, usize)> {
        let _ = (h, from, to);
        None
    }

    /// The next [`Map::change_charts`] goes on to this segment, which [`Map::overdue`] gave.
    fn enter(&mut self, segment: usize) {
        let _ = segment;
    }

    /// Which of several sets of masters φ reads at present, for a map that travels along a chain of
    /// elements; 0 for every other map.
    fn segment(&self) -> usize {
        0
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

/// Where the kinematics of a [`Parametrization`] go; matrices column by column, n×d.
#[allow(missing_docs, reason = "fields are the symbols of docs/notation.md")]
pub struct KinematicsMut<'a> {
    pub x: &'a mut [f64],
    pub x_dot: &'a mut [f64],
    pub x_ddot: &'a mut [f64],
    pub B: &'a mut [f64],
    pub B_dot: &'a mut [f64],
    pub B_ddot: &'a mut [f64],
}

/// A [`Map`] of any dimensions behind a pointer: slices outside, fixed sizes and no heap inside.
///
/// Implemented for every map by [`Map::boxed`], and by maps whose sizes are known at run time only
/// ([`Closed`](crate::implicit::Closed)). Slices have the lengths that [`Parametrization::dims`]
/// says; matrices are stored column by column.
pub trait Parametrization: Send + Sync {
    /// What the map is called in reports: the name of its type unless it has a better one.
    fn kind(&self) -> &'static str {
        std::any::type_name::<Self>()
    }

    /// (d, n): number of coordinates q and number of embedding coordinates x.
    fn dims(&self) -> (usize, usize);

    /// A copy, in the same charts.
    fn duplicate(&self) -> Box<dyn Parametrization>;

    /// See [`Map::margin`]; infinite by default.
    fn margin(&self, t: f64, q: &[f64]) -> f64 {
        let _ = (t, q);
        f64::INFINITY
    }

    /// See [`Map::edge`].
    fn edge(&self) -> &'static str {
        CHART_EDGE
    }

    /// See [`Map::change_charts`]; nothing to do by default.
    fn change_charts(&mut self, t: f64, q: &[f64]) -> ChartChanges {
        let _ = (t, q);
        ChartChanges::default()
    }

    /// See [`Map::is_objective`].
    fn is_objective(&self) -> bool {
        true
    }

    /// Whether φ is linear in q, so that K_σ(f) vanishes and nobody has to ask for it.
    fn is_linear(&self) -> bool {
        false
    }

    /// See [`Map::rewrite`]: the coordinates, their velocities and any number of accelerations are
    /// changed in place; whether they were. Nothing to do by default.
    fn rewrite(&mut self, t: f64, q: &mut [f64], v: &mut [f64], a: &mut [Vec<f64>]) -> bool {
        let _ = (t, q, v, a);
        false
    }

    /// See [`Map::rewrites`].
    fn rewrites(&self) -> bool {
        false
    }

    /// See [`Map::spins`].
    fn spins(&self) -> Option<Spins> {
        None
    }

    /// See [`Map::trouble`].
    fn trouble(&self, t: f64, q: &[f64]) -> Option<String> {
        let _ = (t, q);
        None
    }

    /// See [`Map::note`].
    fn note(&self) -> Option<String> {
        None
    }

    /// See [`Map::overdue`]; both states are (q, q̇).
    fn overdue(&self, h: f64, from: [&[f64]; 2], to: [&[f64]; 2]) -> Option<(f64, usize)> {
        let _ = (h, from, to);
        None
    }

    /// See [`Map::enter`].
    fn enter(&mut self, segment: usize) {
        let _ = segment;
    }

    /// See [`Map::segment`].
    fn segment(&self) -> usize {
        0
    }

    /// What the map remembers of its way besides the coordinates, where it cannot be found from
    /// them: what a checkpoint has to hold.
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Goes on from what [`Parametrization::memory`] gave for the same map; false, and no change,
    /// where that is not of this map.
    fn recall(&mut self, memory: &[f64]) -> bool {
        memory.is_empty()
    }

    /// See [`Map::violation`].
    fn violation(&self, t: f64, q: &[f64]) -> Option<f64> {
        let _ = (t, q);
        None
    }

    /// The Lagrange multipliers of the equations behind the map under the covector `f` (n), where
    /// there are equations; as many as there are.
    fn multipliers(&self, t: f64, q: &[f64], f: &[f64], lambda: &mut [f64]) {
        let _ = (t, q, f);
        lambda.fill(0.0);
    }

    /// Writes x (n) and B (n×d).
    fn tangent(&self, t: f64, q: &[f64], x: &mut [f64], B: &mut [f64]);

    /// Writes x, ẋ, ẍ (n) and B, Ḃ, B̈ (n×d).
    fn kinematics(&self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: KinematicsMut<'_>);

    /// Writes K_σ(f) (d×d).
    fn geometric_stiffness(&self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]);
}

/// The bridge from fixed sizes to slices.
struct Erased<M, const D: usize, const N: usize>(M);

impl<M, const D: usize, const N: usize> Parametrization for Erased<M, D, N>
where
    M: Map<D, N> + Clone + 'static,
{
    fn kind(&self) -> &'static str {
        std::any::type_name::<M>()
    }

    fn dims(&self) -> (usize, usize) {
        (D, N)
    }

    fn duplicate(&self) -> Box<dyn Parametrization> {
        Box::new(Self(self.0.clone()))
    }

    fn margin(&self, t: f64, q: &[f64]) -> f64 {
        self.0.margin(t, &SVector::from_column_slice(q))
    }

    fn edge(&self) -> &'static str {
        self.0.edge()
    }

    fn change_charts(&mut self, t: f64, q: &[f64]) -> ChartChanges {
        self.0.change_charts(t, &SVector::from_column_slice(q))
    }

    fn is_objective(&self) -> bool {
        self.0.is_objective()
    }

    fn rewrite(&mut self, t: f64, q: &mut [f64], v: &mut [f64], a: &mut [Vec<f64>]) -> bool {
        let take = |x: &[f64]| SVector::<f64, D>::from_column_slice(x);
        let Some(new) = self.0.rewrite(t, &take(q), &take(v)) else {
            return false;
        };
        q.copy_from_slice(new.q.as_slice());
        v.copy_from_slice(new.v.as_slice());
        for a in a {
            let accelerations = new.B * take(a) + new.c;
            a.copy_from_slice(accelerations.as_slice());
        }
        true
    }

    fn rewrites(&self) -> bool {
        self.0.rewrites()
    }

    fn spins(&self) -> Option<Spins> {
        self.0.spins()
    }

    fn memory(&self) -> Vec<f64> {
        self.0.memory()
    }

    fn recall(&mut self, memory: &[f64]) -> bool {
        self.0.recall(memory)
    }

    fn trouble(&self, t: f64, q: &[f64]) -> Option<String> {
        self.0.trouble(t, &SVector::from_column_slice(q))
    }

    fn note(&self) -> Option<String> {
        self.0.note()
    }

    fn overdue(&self, h: f64, from: [&[f64]; 2], to: [&[f64]; 2]) -> Option<(f64, usize)> {
        let [from, to] = [from, to].map(|x| x.map(SVector::from_column_slice));
        self.0.overdue(h, from.each_ref(), to.each_ref())
    }

    fn enter(&mut self, segment: usize) {
        self.0.enter(segment);
    }

    fn segment(&self) -> usize {
        self.0.segment()
    }

    fn violation(&self, t: f64, q: &[f64]) -> Option<f64> {
        self.0.violation(t, &SVector::from_column_slice(q))
    }

    fn tangent(&self, t: f64, q: &[f64], x: &mut [f64], B: &mut [f64]) {
        let out = self.0.tangent(t, &SVector::from_column_slice(q));
        x.copy_from_slice(out.x.as_slice());
        B.copy_from_slice(out.B.as_slice());
    }

    fn kinematics(&self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: KinematicsMut<'_>) {
        let k = self.0.kinematics(
            t,
            &SVector::from_column_slice(q),
            &SVector::from_column_slice(v),
            &SVector::from_column_slice(a),
        );
        out.x.copy_from_slice(k.x.as_slice());
        out.x_dot.copy_from_slice(k.x_dot.as_slice());
        out.x_ddot.copy_from_slice(k.x_ddot.as_slice());
        out.B.copy_from_slice(k.B.as_slice());
        out.B_dot.copy_from_slice(k.B_dot.as_slice());
        out.B_ddot.copy_from_slice(k.B_ddot.as_slice());
    }

    fn geometric_stiffness(&self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        let out = self.0.geometric_stiffness(
            t,
            &SVector::from_column_slice(q),
            &SVector::from_column_slice(f),
        );
        K.copy_from_slice(out.as_slice());
    }
}
