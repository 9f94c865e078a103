//! The maps of joints: from the pose of a parent and the coordinates of a joint to the child.

#![allow(non_snake_case)]

use super::link::{Link, orders, put, unit, vector};
use super::{Joint, Slide};
use nalgebra::{SVector, Vector3};
use pullback_manifold::map::{
    KinematicsMut, Map, MapGraph, Parametrization, Read, ToChart, ToPose,
    write_geometric_stiffness, write_kinematics, write_tangent,
};
use pullback_manifold::system::ChartChanges;
use std::f64::consts::TAU;

/// A joint as a map (pose of the parent, q) ↦ pose of the child: see [`ToPose`].
///
/// Outside of its domain is also a joint whose pose has no unit quaternion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointMap<J, const D: usize>(Link<J, D>);

/// A joint whose child turns freely: the map (pose of the parent, q, Ψ of the child) ↦ (d, Ψ) of the child.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeJointMap<J, const D: usize>(Link<J, D>);

impl<J, const D: usize> JointMap<J, D>
where
    J: Joint<D> + Clone + 'static,
{
    /// The map of a joint.
    pub fn new(joint: J) -> Self {
        Self(Link::new(joint))
    }

    /// The same between charts, (d, Ψ of the parent, q) ↦ (d, Ψ of the child), \[M04\] (207).
    pub fn between_charts(self) -> MapGraph {
        let mut graph = MapGraph::new(6 + D);
        let parent = graph.add(Box::new(ToPose), vec![(Read::Input(0), 6)]);
        let child = graph.add(Box::new(self), vec![(parent, 6), (Read::Input(6), D)]);
        graph.add(Box::new(ToChart::default()), vec![(child, 6)]);
        graph.with_outputs(1)
    }
}

impl<J, const D: usize> FreeJointMap<J, D>
where
    J: Joint<D> + Clone + 'static,
{
    /// The map of a joint whose child turns freely.
    pub fn new(joint: J) -> Self {
        Self(Link::new(joint))
    }

    /// The same between charts, (d, Ψ of the parent, q, Ψ of the child) ↦ (d, Ψ of the child).
    pub fn between_charts(self) -> MapGraph {
        let mut graph = MapGraph::new(9 + D);
        let parent = graph.add(Box::new(ToPose), vec![(Read::Input(0), 6)]);
        graph.add(Box::new(self), vec![(parent, 6), (Read::Input(6), 3 + D)]);
        graph.with_outputs(1)
    }

    fn write(&self, t: f64, motion: [&[f64]; 3], out: &mut [[&mut [f64]; 2]]) {
        for (k, [x, B]) in out.iter_mut().enumerate() {
            x[3..].copy_from_slice(vector(motion[k], 6 + D).as_slice());
            B.fill(0.0);
            put(B, 6, [3, 6 + D], &unit(k));
        }
        self.0.carried(t, motion).write_position(out);
    }
}

impl<J, const D: usize> Parametrization for JointMap<J, D>
where
    J: Joint<D> + Clone + 'static,
{
    fn kind(&self) -> &'static str {
        std::any::type_name::<J>()
    }

    fn dims(&self) -> (usize, usize) {
        (6 + D, 6)
    }

    fn duplicate(&self) -> Box<dyn Parametrization> {
        Box::new(self.clone())
    }

    fn margin(&mut self, t: f64, q: &[f64]) -> f64 {
        self.0.margin(t, q)
    }

    fn edge(&self) -> &'static str {
        self.0.joint.edge()
    }

    fn domain_error(&mut self, t: f64, q: &[f64]) -> Option<String> {
        self.0.domain_error(t, q)
    }

    fn freeze_piece(&mut self, at: Option<(f64, &[f64])>) {
        self.0.freeze_piece(at);
    }

    fn tangent(&mut self, t: f64, q: &[f64], x: &mut [f64], B: &mut [f64]) {
        let at = self.0.carried(t, [q, &[], &[]]);
        let mut out = [[x, B]];
        at.write_position(&mut out);
        at.write_rotation(&mut out);
    }

    fn kinematics(&mut self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: KinematicsMut<'_>) {
        let at = self.0.carried(t, [q, v, a]);
        let mut out = orders(out);
        at.write_position(&mut out);
        at.write_rotation(&mut out);
    }

    /// \[M04\] (212) for any joint.
    fn geometric_stiffness(&mut self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        K.fill(0.0);
        let forces = [&vector(f, 0), &vector(f, 3)];
        self.0.write_stiffness((t, q), forces, (K, 6 + D));
    }
}

impl<J, const D: usize> Parametrization for FreeJointMap<J, D>
where
    J: Joint<D> + Clone + 'static,
{
    fn kind(&self) -> &'static str {
        std::any::type_name::<J>()
    }

    fn dims(&self) -> (usize, usize) {
        (9 + D, 6)
    }

    fn duplicate(&self) -> Box<dyn Parametrization> {
        Box::new(self.clone())
    }

    fn margin(&mut self, t: f64, q: &[f64]) -> f64 {
        let own = self.0.margin(t, q);
        match own.is_nan() {
            true => own,
            false => own.min(TAU - vector(q, 6 + D).norm()),
        }
    }

    fn edge(&self) -> &'static str {
        self.0.joint.edge()
    }

    fn domain_error(&mut self, t: f64, q: &[f64]) -> Option<String> {
        self.0.domain_error(t, q)
    }

    fn freeze_piece(&mut self, at: Option<(f64, &[f64])>) {
        self.0.freeze_piece(at);
    }

    fn tangent(&mut self, t: f64, q: &[f64], x: &mut [f64], B: &mut [f64]) {
        self.write(t, [q, &[], &[]], &mut [[x, B]]);
    }

    fn kinematics(&mut self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: KinematicsMut<'_>) {
        self.write(t, [q, v, a], &mut orders(out));
    }

    fn geometric_stiffness(&mut self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        K.fill(0.0);
        let forces = [&vector(f, 0), &Vector3::zeros()];
        self.0.write_stiffness((t, q), forces, (K, 9 + D));
    }
}

/// Along a chain of beam elements: its segment is part of its state.
impl Parametrization for Slide {
    fn dims(&self) -> (usize, usize) {
        (13, 6)
    }

    fn duplicate(&self) -> Box<dyn Parametrization> {
        Box::new(self.clone())
    }

    fn margin(&mut self, t: f64, q: &[f64]) -> f64 {
        Map::margin(self, t, &SVector::from_column_slice(q))
    }

    fn edge(&self) -> &'static str {
        Map::edge(self)
    }

    fn change_charts(&mut self, _t: f64, q: &[f64]) -> ChartChanges {
        let psi = [3, 9].map(|k| Vector3::new(q[k], q[k + 1], q[k + 2]));
        let on = self.chain.change_segments(q[12]);
        // Handed over, it has the nodes of another element than `q`.
        let residual = self.turn.choose((!on).then_some(psi)) || on;
        let charts = usize::from(residual);
        ChartChanges { charts, residual }
    }

    fn segment(&self) -> usize {
        self.chain.line()
    }

    fn overshoot(&self, h: f64, from: [&[f64]; 2], to: [&[f64]; 2]) -> Option<(f64, usize)> {
        let [from, to] = [from, to].map(|[q, v]| [q[12], v[12]]);
        self.chain.leaves(h, from, to)
    }

    fn enter(&mut self, segment: usize) {
        self.chain.enter(segment as f64);
    }

    fn save(&self) -> Vec<f64> {
        vec![self.chain.line() as f64]
    }

    fn restore(&mut self, saved: &[f64]) -> bool {
        matches!(*saved, [line] if self.chain.enter(line))
    }

    fn tangent(&mut self, t: f64, q: &[f64], x: &mut [f64], B: &mut [f64]) {
        write_tangent(self, t, q, x, B);
    }

    fn kinematics(&mut self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: KinematicsMut<'_>) {
        write_kinematics(self, t, [q, v, a], out);
    }

    fn geometric_stiffness(&mut self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        write_geometric_stiffness(self, t, q, f, K);
    }
}
