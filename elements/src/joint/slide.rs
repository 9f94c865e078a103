//! The slide: a frame that runs along a chain of two-node beam elements.

#![allow(non_snake_case)]

use super::shape::{Between, Chain};
use crate::beam::Interpolation;
use nalgebra::{SVector, Vector3};
use pullback_manifold::map::{
    KinematicsMut, Map, Parametrization, write_geometric_stiffness, write_kinematics, write_tangent,
};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::system::ChartChanges;
use std::f64::consts::TAU;

/// d_s = Σ Nᵢ(u)(Xᵢ + dᵢ) − X_s, Ψ_s = Σ Nᵢ(u) Ψᵢ with the shape functions of the beam element on
/// which the frame is (\[M04\] 4.1.3, (198)): parents (frame, frame, u). On geodesic elements its
/// rotation is theirs, R_s = R₁ exp(N₂(u) log(R₁ᵀ R₂)).
///
/// u is the arc length of the reference configuration from where the frame starts, positive towards
/// the end of the chain: one coordinate for all its elements, zero in the reference. Where it
/// passes the end of an element a step ends, and the next element takes over; beyond the ends of the
/// chain the joint is outside its domain. A closed ring is a chain that goes round as often as the frame
/// may: its nodes may occur again.
///
#[doc = include_str!("../../../docs/images/joints/slide.svg")]
#[derive(Clone, Debug, PartialEq)]
pub struct Slide {
    /// The beams' axes in the reference configuration.
    chain: Chain,
    turn: Between,
}

impl Slide {
    /// A slide along elements that interpolate rotations so.
    pub fn new(chain: Chain, interpolation: Interpolation) -> Self {
        let turn = Between::new(interpolation);
        Self { chain, turn }
    }
}

impl Map<13, 6> for Slide {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 13>) -> SVector<S, 6> {
        let three = |k: usize| Vector3::new(q[k], q[k + 1], q[k + 2]);
        let [a, b] = self.chain.shape(q[12]);
        let d = self.chain.displacement(q[12]) + three(0) * a + three(6) * b;
        let psi = self.turn.at([three(3), three(9)], [a, b]);
        SVector::<S, 6>::new(d.x, d.y, d.z, psi.x, psi.y, psi.z)
    }

    fn margin(&self, t: f64, q: &SVector<f64, 13>) -> f64 {
        let psi = self.phi(t, q).fixed_rows::<3>(3).norm();
        self.chain.room(q[12]).min(TAU - psi)
    }

    fn edge(&self) -> &'static str {
        "its chain of beams over an end: make the chain longer, or stop before"
    }
}

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
