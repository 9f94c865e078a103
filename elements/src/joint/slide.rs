//! The slide: a frame that runs along a chain of two-node beam elements.

#![allow(non_snake_case)]

use super::Sheet;
use crate::beam::Interpolation;
use crate::model::{ModelBuilder, ModelError, NodeId};
use nalgebra::{SVector, Vector3};
use pullback_manifold::map::Map;
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::{complement, log_quaternion, quaternion};
use pullback_manifold::system::{ChartChanges, Kind};
use std::f64::consts::TAU;

/// d_s = Σ Nᵢ(u)(Xᵢ + dᵢ) − X_s, Ψ_s = Σ Nᵢ(u) Ψᵢ with the shape functions of the beam element on
/// which the frame is (\[M04\] 4.1.3, (198)): masters (frame, frame, u). On geodesic elements its
/// rotation is theirs, R_s = R₁ exp(N₂(u) log(R₁ᵀ R₂)).
///
/// u is the arc length of the reference configuration from where the frame starts, positive towards
/// the end of the chain: one coordinate for all its elements, zero in the reference. At a converged state beyond the end of an element the next one
/// takes over; beyond the ends of the chain the joint is outside its domain.
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
    interpolation: Interpolation,
    /// Sheets on which the rotation vectors of the two ends are interpolated: those of the beam.
    sheets: [Sheet; 2],
}

impl Slide {
    /// A slide over nodes at these places, starting at `origin` along the chain; `None` when there
    /// are fewer than two nodes, neighbours coincide, or `origin` is outside the chain.
    pub fn new(places: &[Vector3<f64>], origin: f64) -> Option<Self> {
        let mut lengths = vec![0.0];
        for pair in places.windows(2) {
            let length = (pair[1] - pair[0]).norm();
            if length.is_nan() || length <= 0.0 {
                return None;
            }
            lengths.push(lengths[lengths.len() - 1] + length);
        }
        let end = *lengths.last()?;
        if places.len() < 2 || !(0.0..=end).contains(&origin) {
            return None;
        }
        let mut slide = Self {
            places: places.to_vec(),
            lengths,
            origin,
            start: Vector3::zeros(),
            segment: 0,
            interpolation: Interpolation::Total,
            sheets: [Sheet::Same; 2],
        };
        slide.segment = slide.element_at(0.0);
        let [a, b] = slide.shape(0.0);
        slide.start = places[slide.segment] * a + places[slide.segment + 1] * b;
        Some(slide)
    }

    /// The same slide on elements with this interpolation of rotations; by default
    /// [`Interpolation::Total`].
    #[must_use]
    pub fn with_interpolation(self, interpolation: Interpolation) -> Self {
        Self {
            interpolation,
            ..self
        }
    }

    /// Reference place of the frame at the start.
    pub fn place(&self) -> Vector3<f64> {
        self.start
    }

    fn element_at(&self, u: f64) -> usize {
        let after = self.lengths.partition_point(|&s| s <= self.origin + u);
        after.clamp(1, self.places.len() - 1) - 1
    }

    /// The two shape functions of the present element.
    fn shape<S: Scalar>(&self, u: S) -> [S; 2] {
        let (from, to) = (self.lengths[self.segment], self.lengths[self.segment + 1]);
        let b = (u + (self.origin - from)) / (to - from);
        [S::one() - b, b]
    }
}

/// Ψ, or its complement.
fn on<S: Scalar>(sheet: Sheet, psi: &Vector3<S>) -> Vector3<S> {
    match sheet {
        Sheet::Same => *psi,
        Sheet::Opposite => complement(psi),
    }
}

impl Map<13, 6> for Slide {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 13>) -> SVector<S, 6> {
        let [a, b] = self.shape(q[12]);
        let three = |k: usize| Vector3::new(q[k], q[k + 1], q[k + 2]);
        let place = |k: usize| self.places[self.segment + k].map(S::constant);
        let d = (place(0) + three(0)) * a + (place(1) + three(6)) * b - self.start.map(S::constant);
        let ends = [on(self.sheets[0], &three(3)), on(self.sheets[1], &three(9))];
        let psi = match self.interpolation {
            Interpolation::Total => ends[0] * a + ends[1] * b,
            Interpolation::Geodesic => {
                let [p, r] = [quaternion(&ends[0]), quaternion(&ends[1])];
                let theta = log_quaternion(&p.conjugate().product(&r));
                log_quaternion(&p.product(&quaternion(&(theta * b))))
            }
        };
        SVector::<S, 6>::new(d.x, d.y, d.z, psi.x, psi.y, psi.z)
    }

    fn margin(&self, t: f64, q: &SVector<f64, 13>) -> f64 {
        let (s, end) = (self.origin + q[12], self.lengths[self.lengths.len() - 1]);
        // A hair more than the chain, so that a frame may rest on its end.
        let ends = s.min(end - s) + 1e-9 * end;
        let x = self.phi(t, q);
        ends.min(TAU - Vector3::new(x[3], x[4], x[5]).norm())
    }

    fn edge(&self) -> &'static str {
        "its chain of beams over an end: make the chain longer, or stop before"
    }

    fn change_charts(&mut self, _t: f64, q: &SVector<f64, 13>) -> ChartChanges {
        let (segment, sheets) = (self.segment, self.sheets);
        self.segment = self.element_at(q[12]);
        let mut charts = 0;
        if self.segment == segment {
            // The chart in which the larger of the two angles is smaller, as the beam itself has it.
            let psi = [3, 9].map(|k| Vector3::new(q[k], q[k + 1], q[k + 2]));
            let angle = psi.map(|p| p.norm());
            let agree = quaternion(&psi[0]).dot(&quaternion(&psi[1])) >= 0.0;
            self.sheets = match agree {
                true if angle[0].max(angle[1]) > TAU - angle[0].min(angle[1]) => {
                    [Sheet::Opposite; 2]
                }
                true => [Sheet::Same; 2],
                false if angle[0].max(TAU - angle[1]) <= angle[1].max(TAU - angle[0]) => {
                    [Sheet::Same, Sheet::Opposite]
                }
                false => [Sheet::Opposite, Sheet::Same],
            };
            charts += usize::from(self.sheets != sheets);
        } else {
            // Its nodes' coordinates are not those in `q`: their sheets are chosen when they are.
            self.sheets = [Sheet::Same; 2];
            charts += 1;
        }
        ChartChanges {
            charts,
            residual: charts > 0,
        }
    }

    fn segment(&self) -> usize {
        self.segment
    }
}

/// The nodes of a slide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlideNodes {
    /// The frame that runs along the chain.
    pub frame: NodeId,
    /// Its way along the chain in the reference configuration: the released coordinate.
    pub way: NodeId,
}

/// Adds a frame node `name` that slides along the two-node beam elements between `chain`'s nodes,
/// starting at arc length `origin` of the chain, and the node `name way` of its coordinate. The
/// elements interpolate total rotation vectors; [`slide_on`] is for others.
///
/// # Errors
/// [`ModelError::Slide`] for a chain that is none or a start outside it; as
/// [`ModelBuilder::mapped_node`].
pub fn slide(
    b: &mut ModelBuilder,
    name: &str,
    chain: &[NodeId],
    origin: f64,
) -> Result<SlideNodes, ModelError> {
    slide_on(b, name, chain, origin, Interpolation::Total)
}

/// As [`slide`], on elements with this interpolation of rotations.
///
/// # Errors
/// As there.
pub fn slide_on(
    b: &mut ModelBuilder,
    name: &str,
    chain: &[NodeId],
    origin: f64,
    interpolation: Interpolation,
) -> Result<SlideNodes, ModelError> {
    let places: Vec<Vector3<f64>> = chain.iter().map(|&n| b.place(n)).collect();
    let joint = Slide::new(&places, origin).ok_or_else(|| ModelError::Slide {
        joint: name.to_owned(),
        nodes: chain.len(),
        start: origin,
    })?;
    let joint = joint.with_interpolation(interpolation);
    let way = b.coordinates(format!("{name} way"), &[Kind::Length])?;
    let place = joint.place().into();
    let segments: Vec<[NodeId; 3]> = chain.windows(2).map(|p| [p[0], p[1], way]).collect();
    let segments: Vec<&[NodeId]> = segments.iter().map(|s| &s[..]).collect();
    let frame = b.mapped_node_along(name, place, joint.boxed(), &segments)?;
    Ok(SlideNodes { frame, way })
}
