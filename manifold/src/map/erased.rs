//! The object-safe interface to maps of any dimensions.

use super::{Duplicate, Map, MapState, Reparametrization, Segments};
use crate::domain::DomainError;
use crate::implicit::ImplicitMap;
use nalgebra::{SMatrix, SVector};

/// The coordinates (n) and the operator (n×d, column by column) of one order of time derivatives.
pub type Order<'a> = [&'a mut [f64]; 2];

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
/// Implemented for every map by [`Map::boxed`], and by maps with segments or with sizes known only at run time
/// ([`ImplicitMap`]). Slices have the lengths of [`Parametrization::dims`];
/// matrices are stored column by column. A map without an ability gives `None`, the default.
pub trait Parametrization: Duplicate + Send + Sync {
    /// Name of the map in reports; the name of its type by default.
    fn kind(&self) -> &'static str {
        std::any::type_name::<Self>()
    }

    /// (d, n): number of coordinates q and number of embedding coordinates x.
    fn dims(&self) -> (usize, usize);

    /// See [`Map::domain`]; infinite by default.
    ///
    /// # Errors
    /// [`DomainError`] outside.
    fn domain(&mut self, t: f64, q: &[f64]) -> Result<f64, DomainError> {
        let _ = (t, q);
        Ok(f64::INFINITY)
    }

    /// See [`Map::is_objective`].
    fn is_objective(&self) -> bool {
        true
    }

    /// Writes as many orders as `out` has: x and B at q alone, or these with ẋ and Ḃ, ẍ and B̈ along the motion q, q̇, q̈.
    fn evaluate(&mut self, t: f64, motion: [&[f64]; 3], out: &mut [Order<'_>]);

    /// Writes K_σ(f) (d×d).
    fn geometric_stiffness(&mut self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]);

    /// See [`Map::state`].
    fn state(&mut self) -> Option<&mut dyn MapState> {
        None
    }

    /// Segments with different parents.
    fn segments(&self) -> Option<&dyn Segments> {
        None
    }
}

impl dyn Parametrization + '_ {
    /// Writes x (n) and B (n×d).
    pub fn tangent(&mut self, t: f64, q: &[f64], x: &mut [f64], B: &mut [f64]) {
        self.evaluate(t, [q, &[], &[]], &mut [[x, B]]);
    }

    /// [`MapState::reparametrization`]; `None` without a state.
    pub fn reparametrization(&mut self) -> Option<&mut dyn Reparametrization> {
        self.state()?.reparametrization()
    }

    /// [`MapState::implicit`]; `None` without a state.
    pub fn implicit(&mut self) -> Option<&mut ImplicitMap> {
        self.state()?.implicit()
    }

    /// Index of the set of parents that φ reads at present: [`Segments::segment`], or 0.
    pub fn segment(&self) -> usize {
        self.segments().map_or(0, Segments::segment)
    }

    /// [`MapState::save`]; empty without a state.
    pub fn save(&self) -> Vec<f64> {
        let mut copy = self.duplicate();
        copy.state().map_or_else(Vec::new, |state| state.save())
    }

    /// [`MapState::restore`]; without a state, whether nothing is saved.
    pub fn restore(&mut self, saved: &[f64]) -> bool {
        self.state()
            .map_or(saved.is_empty(), |state| state.restore(saved))
    }
}

/// A map behind slices.
#[derive(Clone)]
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

    fn domain(&mut self, t: f64, q: &[f64]) -> Result<f64, DomainError> {
        self.0.domain(t, &SVector::from_column_slice(q))
    }

    fn is_objective(&self) -> bool {
        self.0.is_objective()
    }

    fn evaluate(&mut self, t: f64, motion: [&[f64]; 3], out: &mut [Order<'_>]) {
        write_orders(&self.0, t, motion, out);
    }

    fn geometric_stiffness(&mut self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        write_geometric_stiffness(&self.0, t, q, f, K);
    }

    fn state(&mut self) -> Option<&mut dyn MapState> {
        self.0.state()
    }
}

/// [`Parametrization::evaluate`] of a map.
pub fn write_orders<const D: usize, const N: usize>(
    map: &impl Map<D, N>,
    t: f64,
    [q, v, a]: [&[f64]; 3],
    out: &mut [Order<'_>],
) {
    let q = SVector::from_column_slice(q);
    if let [[x, B]] = out {
        let at = map.tangent(t, &q);
        x.copy_from_slice(at.x.as_slice());
        B.copy_from_slice(at.B.as_slice());
        return;
    }
    let [v, a] = [v, a].map(SVector::from_column_slice);
    let k = map.kinematics(t, &q, &v, &a);
    let orders = [(&k.x, &k.B), (&k.x_dot, &k.B_dot), (&k.x_ddot, &k.B_ddot)];
    for ([x, B], (value, operator)) in out.iter_mut().zip(orders) {
        x.copy_from_slice(value.as_slice());
        B.copy_from_slice(operator.as_slice());
    }
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
