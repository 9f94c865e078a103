//! The object-safe interface to maps of any dimensions.

#![allow(non_snake_case)]

use super::Map;
use crate::so3::VelocityKind;
use crate::system::{CHART_EDGE, ChartChanges};
use nalgebra::SVector;

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

/// An object-safe [`Map`] of any dimensions: slices outside, fixed sizes and no heap inside.
///
/// Implemented for every map by [`Map::boxed`], and by maps whose sizes are known only at run time
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

    /// Whether φ is linear in q, so that K_σ(f) vanishes and is not evaluated.
    fn is_linear(&self) -> bool {
        false
    }

    /// See [`Map::reparametrize`]: transforms the coordinates, their velocities and any number of
    /// accelerations in place; returns whether they changed. Nothing by default.
    fn reparametrize(&mut self, t: f64, q: &mut [f64], v: &mut [f64], a: &mut [Vec<f64>]) -> bool {
        let _ = (t, q, v, a);
        false
    }

    /// See [`Map::reparametrizes`].
    fn reparametrizes(&self) -> bool {
        false
    }

    /// See [`Map::velocity_kind`].
    fn velocity_kind(&self) -> Option<VelocityKind> {
        None
    }

    /// Why q is outside the domain, to follow "joint at node a: "; none by default.
    fn domain_error(&self, t: f64, q: &[f64]) -> Option<String> {
        let _ = (t, q);
        None
    }

    /// A warning about a nearby singular configuration, if any, to follow "joint at node a: ".
    fn singularity_warning(&self) -> Option<String> {
        None
    }

    /// Describes the present state of the map (independent coordinates, redundant equations) for
    /// reports; none by default.
    fn describe(&self) -> Option<String> {
        None
    }

    /// See [`Map::overshoot`]; both states are (q, q̇).
    fn overshoot(&self, h: f64, from: [&[f64]; 2], to: [&[f64]; 2]) -> Option<(f64, usize)> {
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

    /// See [`Map::freeze_piece`].
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

    /// Largest residual at φ(t, q) of the equations behind the map, each relative to its size;
    /// `None` for an explicit map.
    fn violation(&self, t: f64, q: &[f64]) -> Option<f64> {
        let _ = (t, q);
        None
    }

    /// Lagrange multipliers of the equations behind the map under the covector `f` (n), one per
    /// equation.
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

impl Clone for Box<dyn Parametrization> {
    fn clone(&self) -> Self {
        self.duplicate()
    }
}

/// Adapter from fixed sizes to slices.
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

    fn reparametrize(&mut self, t: f64, q: &mut [f64], v: &mut [f64], a: &mut [Vec<f64>]) -> bool {
        let take = |x: &[f64]| SVector::<f64, D>::from_column_slice(x);
        let Some(new) = self.0.reparametrize(t, &take(q), &take(v)) else {
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

    fn reparametrizes(&self) -> bool {
        self.0.reparametrizes()
    }

    fn velocity_kind(&self) -> Option<VelocityKind> {
        self.0.velocity_kind()
    }

    fn save(&self) -> Vec<f64> {
        self.0.save()
    }

    fn restore(&mut self, saved: &[f64]) -> bool {
        self.0.restore(saved)
    }

    fn overshoot(&self, h: f64, from: [&[f64]; 2], to: [&[f64]; 2]) -> Option<(f64, usize)> {
        let [from, to] = [from, to].map(|x| x.map(SVector::from_column_slice));
        self.0.overshoot(h, from.each_ref(), to.each_ref())
    }

    fn enter(&mut self, segment: usize) {
        self.0.enter(segment);
    }

    fn segment(&self) -> usize {
        self.0.segment()
    }

    fn freeze_piece(&mut self, at: Option<(f64, &[f64])>) {
        let at = at.map(|(t, q)| (t, SVector::from_column_slice(q)));
        self.0.freeze_piece(at.as_ref().map(|(t, q)| (*t, q)));
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
