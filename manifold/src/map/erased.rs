//! The object-safe interface to maps of any dimensions.

#![allow(non_snake_case)]

use super::Map;
use crate::domain::DomainError;
use crate::implicit::ImplicitMap;
use crate::so3::VelocityKind;
use crate::system::ChartChanges;
use nalgebra::{SMatrix, SVector};

/// Output of [`Parametrization::kinematics`]; matrices column by column, n×d.
#[allow(missing_docs, reason = "fields are the symbols of docs/notation.md")]
pub struct KinematicsMut<'a> {
    pub x: &'a mut [f64],
    pub x_dot: &'a mut [f64],
    pub x_ddot: &'a mut [f64],
    pub B: &'a mut [f64],
    pub B_dot: &'a mut [f64],
    pub B_ddot: &'a mut [f64],
}

impl<'a> KinematicsMut<'a> {
    /// Coordinates and operators, order by order.
    pub fn orders(self) -> [[&'a mut [f64]; 2]; 3] {
        [
            [self.x, self.B],
            [self.x_dot, self.B_dot],
            [self.x_ddot, self.B_ddot],
        ]
    }
}

/// Writes a block into a matrix of `n` rows, column by column.
pub fn write_block<const M: usize, const N: usize>(
    into: &mut [f64],
    n: usize,
    [row, column]: [usize; 2],
    block: &SMatrix<f64, M, N>,
) {
    for (j, values) in block.column_iter().enumerate() {
        let first = (column + j) * n + row;
        into[first..first + M].copy_from_slice(values.as_slice());
    }
}

/// An object-safe [`Map`] of any dimensions: slices outside, fixed sizes and no heap inside.
///
/// Implemented for every map by [`Map::boxed`], and by maps with a state of their own
/// ([`Increment`](super::Increment)) or sizes known only at run time
/// ([`ImplicitMap`](crate::implicit::ImplicitMap)). Slices have the lengths of [`Parametrization::dims`];
/// matrices are stored column by column.
pub trait Parametrization: Send + Sync {
    /// Name of the map in reports; the name of its type by default.
    fn kind(&self) -> &'static str {
        std::any::type_name::<Self>()
    }

    /// (d, n): number of coordinates q and number of embedding coordinates x.
    fn dims(&self) -> (usize, usize);

    /// A copy, in the same charts.
    fn duplicate(&self) -> Box<dyn Parametrization>;

    /// See [`Map::domain`]; infinite by default.
    ///
    /// # Errors
    /// [`DomainError`] outside.
    fn domain(&mut self, t: f64, q: &[f64]) -> Result<f64, DomainError> {
        let _ = (t, q);
        Ok(f64::INFINITY)
    }

    /// Changes the charts of the values (branch of a logarithm, segment of a curve) if another one is
    /// better at q. Called at converged states only: within a step φ is one smooth function. Nothing by
    /// default.
    fn change_charts(&mut self, t: f64, q: &[f64]) -> ChartChanges {
        let _ = (t, q);
        ChartChanges::default()
    }

    /// See [`Map::is_objective`].
    fn is_objective(&self) -> bool {
        true
    }

    /// Whether φ is linear in q, so that K_σ(f) vanishes and is not evaluated.
    fn is_linear(&self) -> bool {
        false
    }

    /// Changes the coordinates q to better ones: transforms them, their velocities and any number of
    /// accelerations in place, and returns whether they changed; x, ẋ and ẍ stay the same to rounding.
    /// Called at every converged state, and never between. Nothing by default; a map that overrides it
    /// also overrides [`Parametrization::reparametrizes`].
    fn reparametrize(&mut self, t: f64, q: &mut [f64], v: &mut [f64], a: &mut [Vec<f64>]) -> bool {
        let _ = (t, q, v, a);
        false
    }

    /// Whether [`Parametrization::reparametrize`] may change q: no other map or element may then use
    /// these coordinates.
    fn reparametrizes(&self) -> bool {
        false
    }

    /// Kind of angular velocity that replaces the rates of the last three coordinates θ at present,
    /// if any: Ω and Ω̇ are then stored as velocities and accelerations. The model converts them to
    /// θ̇ and θ̈ before it evaluates the map ([`so3::Spin`](crate::so3::Spin)). None by default.
    fn velocity_kind(&self) -> Option<VelocityKind> {
        None
    }

    /// Amount by which a step of size h between two states (q, q̇) overshot the first change of
    /// segment, in units of time, negative before it; and the new segment. Integrators end a step
    /// there. `None` if there is no change ahead, and by default.
    fn overshoot(&self, h: f64, from: [&[f64]; 2], to: [&[f64]; 2]) -> Option<(f64, usize)> {
        let _ = (h, from, to);
        None
    }

    /// Makes the next [`Parametrization::change_charts`] enter this segment, a result of
    /// [`Parametrization::overshoot`].
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
    fn freeze_piece(&mut self, at: Option<(f64, &[f64])>) {
        let _ = at;
    }

    /// State of the map besides the coordinates that cannot be found from them, for checkpoints.
    fn save(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Restores the state from [`Parametrization::save`] of the same map; false, without a change,
    /// if it belongs to another map.
    fn restore(&mut self, saved: &[f64]) -> bool {
        saved.is_empty()
    }

    /// The equations that it solves; `None` for an explicit map.
    fn implicit(&mut self) -> Option<&mut ImplicitMap> {
        None
    }

    /// Writes x (n) and B (n×d).
    fn tangent(&mut self, t: f64, q: &[f64], x: &mut [f64], B: &mut [f64]);

    /// Writes x, ẋ, ẍ (n) and B, Ḃ, B̈ (n×d).
    fn kinematics(&mut self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: KinematicsMut<'_>);

    /// Writes K_σ(f) (d×d).
    fn geometric_stiffness(&mut self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]);
}

impl Clone for Box<dyn Parametrization> {
    fn clone(&self) -> Self {
        self.duplicate()
    }
}

/// A map behind slices.
pub(super) struct Erased<M, const D: usize, const N: usize>(pub(super) M);

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

    fn domain(&mut self, t: f64, q: &[f64]) -> Result<f64, DomainError> {
        self.0.domain(t, &SVector::from_column_slice(q))
    }

    fn is_objective(&self) -> bool {
        self.0.is_objective()
    }

    fn tangent(&mut self, t: f64, q: &[f64], x: &mut [f64], B: &mut [f64]) {
        write_tangent(&self.0, t, q, x, B);
    }

    fn kinematics(&mut self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: KinematicsMut<'_>) {
        write_kinematics(&self.0, t, [q, v, a], out);
    }

    fn geometric_stiffness(&mut self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        write_geometric_stiffness(&self.0, t, q, f, K);
    }
}

/// [`Parametrization::tangent`] of a map.
pub fn write_tangent<const D: usize, const N: usize>(
    map: &impl Map<D, N>,
    t: f64,
    q: &[f64],
    x: &mut [f64],
    B: &mut [f64],
) {
    let out = map.tangent(t, &SVector::from_column_slice(q));
    x.copy_from_slice(out.x.as_slice());
    B.copy_from_slice(out.B.as_slice());
}

/// [`Parametrization::kinematics`] of a map along a motion (q, q̇, q̈).
pub fn write_kinematics<const D: usize, const N: usize>(
    map: &impl Map<D, N>,
    t: f64,
    motion: [&[f64]; 3],
    out: KinematicsMut<'_>,
) {
    let [q, v, a] = motion.map(SVector::from_column_slice);
    let k = map.kinematics(t, &q, &v, &a);
    out.x.copy_from_slice(k.x.as_slice());
    out.x_dot.copy_from_slice(k.x_dot.as_slice());
    out.x_ddot.copy_from_slice(k.x_ddot.as_slice());
    out.B.copy_from_slice(k.B.as_slice());
    out.B_dot.copy_from_slice(k.B_dot.as_slice());
    out.B_ddot.copy_from_slice(k.B_ddot.as_slice());
}

/// [`Parametrization::geometric_stiffness`] of a map.
pub fn write_geometric_stiffness<const D: usize, const N: usize>(
    map: &impl Map<D, N>,
    t: f64,
    q: &[f64],
    f: &[f64],
    K: &mut [f64],
) {
    let (q, f) = (SVector::from_column_slice(q), SVector::from_column_slice(f));
    K.copy_from_slice(map.geometric_stiffness(t, &q, &f).as_slice());
}
