//! The chain of elements that a slide runs along, and how it is handed over from one to the next.

use super::Slide;
use crate::beam::Interpolation;
use crate::joint::Sheet;
use nalgebra::{SVector, Vector3};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::{complement, quaternion};
use pullback_manifold::system::ChartChanges;
use std::f64::consts::TAU;

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
    pub(super) fn shape<S: Scalar>(&self, u: S) -> [S; 2] {
        let (from, to) = (self.lengths[self.segment], self.lengths[self.segment + 1]);
        let b = (u + (self.origin - from)) / (to - from);
        [S::one() - b, b]
    }

    /// The way to the nearer end of the chain, and a hair more, so that a frame may rest there.
    pub(super) fn room(&self, u: f64) -> f64 {
        let (s, end) = (self.origin + u, self.lengths[self.lengths.len() - 1]);
        s.min(end - s) + 1e-9 * end
    }

    /// The time since u has passed the end of the present element that lies ahead, if another one
    /// follows there.
    pub(super) fn past_end(&self, u: f64, u_dot: f64) -> Option<f64> {
        let ahead = self.segment + usize::from(u_dot > 0.0);
        let inside = ahead > 0 && ahead + 1 < self.lengths.len();
        let late = (self.origin + u - self.lengths[ahead]) / u_dot;
        (inside && late.is_finite()).then_some(late)
    }

    /// Goes on to the element behind whose end the frame has come, or to the charts that the beam has
    /// here.
    pub(super) fn hand_over(&mut self, q: &SVector<f64, 13>) -> ChartChanges {
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
}

/// Ψ, or its complement.
pub(super) fn on<S: Scalar>(sheet: Sheet, psi: &Vector3<S>) -> Vector3<S> {
    match sheet {
        Sheet::Same => *psi,
        Sheet::Opposite => complement(psi),
    }
}
