//! The slide: a frame that runs along a chain of two-node beam elements.

mod chain;
mod nodes;

pub use nodes::{SlideNodes, slide, slide_on};

use super::Sheet;
use crate::beam::Interpolation;
use chain::{between, on};
use nalgebra::{SVector, Vector3};
use pullback_manifold::map::{Map, Motion};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::system::ChartChanges;
use std::f64::consts::TAU;

/// d_s = Σ Nᵢ(u)(Xᵢ + dᵢ) − X_s, Ψ_s = Σ Nᵢ(u) Ψᵢ with the shape functions of the beam element on
/// which the frame is (\[M04\] 4.1.3, (198)): masters (frame, frame, u). On geodesic elements its
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
    /// Reference places of the chain's nodes and their arc lengths.
    places: Vec<Vector3<f64>>,
    lengths: Vec<f64>,
    /// Where u = 0: arc length from the beginning of the chain, and reference place.
    origin: f64,
    start: Vector3<f64>,
    segment: usize,
    /// The element that takes over next.
    next: Option<usize>,
    interpolation: Interpolation,
    /// Sheets on which the rotation vectors of the two ends are interpolated: those of the beam.
    sheets: [Sheet; 2],
}

impl Map<13, 6> for Slide {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 13>) -> SVector<S, 6> {
        let [a, b] = self.shape(q[12]);
        let three = |k: usize| Vector3::new(q[k], q[k + 1], q[k + 2]);
        let place = |k: usize| self.places[self.segment + k].map(S::constant);
        let d = (place(0) + three(0)) * a + (place(1) + three(6)) * b - self.start.map(S::constant);
        let ends = [on(self.sheets[0], &three(3)), on(self.sheets[1], &three(9))];
        let psi = between(self.interpolation, ends, [a, b]);
        SVector::<S, 6>::new(d.x, d.y, d.z, psi.x, psi.y, psi.z)
    }

    fn margin(&self, t: f64, q: &SVector<f64, 13>) -> f64 {
        let psi = self.phi(t, q).fixed_rows::<3>(3).norm();
        self.room(q[12]).min(TAU - psi)
    }

    fn edge(&self) -> &'static str {
        "its chain of beams over an end: make the chain longer, or stop before"
    }

    fn change_charts(&mut self, _t: f64, q: &SVector<f64, 13>) -> ChartChanges {
        self.hand_over(q)
    }

    fn segment(&self) -> usize {
        self.segment
    }

    fn overdue(&self, h: f64, from: Motion<'_, 13>, to: Motion<'_, 13>) -> Option<(f64, usize)> {
        let [from, to] = [from, to].map(|[q, v]| [q[12], v[12]]);
        self.leaves(h, from, to)
    }

    fn enter(&mut self, segment: usize) {
        self.next = Some(segment);
    }

    fn memory(&self) -> Vec<f64> {
        vec![self.segment as f64]
    }

    fn recall(&mut self, memory: &[f64]) -> bool {
        self.remember(memory)
    }
}
