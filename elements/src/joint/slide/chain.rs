//! The chain of elements that a slide runs along, and how it is handed over from one to the next.

use super::Slide;
use crate::beam::Interpolation;
use crate::joint::Sheet;
use nalgebra::{SVector, Vector3};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::{complement, log_quaternion, quaternion};
use pullback_manifold::system::ChartChanges;
use std::f64::consts::TAU;

/// Excursions beyond an end below this part of the chain are rounding errors.
const GRAIN: f64 = 4e-15;
/// A frame that is this part of the chain beyond an end may be on its way back.
const HAIR: f64 = 1e-8;

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
            next: None,
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

    /// When u first leaves the present element for another one, on the cubic between two states
    /// (u, u̇) that a step of size h lies between: how long before its end, and for which element. Where
    /// it does not, the same by the velocity at the end.
    pub(super) fn leaves(
        &self,
        h: f64,
        [u0, v0]: [f64; 2],
        [u1, v1]: [f64; 2],
    ) -> Option<(f64, usize)> {
        let k = self.segment;
        let ends = [self.lengths[k], self.lengths[k + 1]].map(|s| s - self.origin);
        let after = (k + 2 < self.lengths.len()).then_some(k + 1);
        let elements = [k.checked_sub(1), after];
        // u0 + c s + b s² + a s³, s = 0 … 1.
        let way = u1 - u0;
        let (a, b) = (h * (v0 + v1) - 2.0 * way, 3.0 * way - h * (2.0 * v0 + v1));
        let c = h * v0;
        let u = |s: f64| {
            if s == 1.0 {
                u1
            } else {
                u0 + s * (c + s * (b + s * a))
            }
        };
        let grain = GRAIN * self.lengths[self.lengths.len() - 1];
        let mut from = 0.0;
        for to in turns(a, b, c).into_iter().chain([1.0]) {
            let up = u(to) > u(from);
            let (end, sign) = if up { (ends[1], 1.0) } else { (ends[0], -1.0) };
            let beyond = |s: f64, by: f64| sign * (u(s) - end) > by;
            if let (true, Some(element)) = (beyond(to, grain), elements[usize::from(up)]) {
                let (mut inside, mut outside) = (from, to);
                for _ in 0..f64::MANTISSA_DIGITS {
                    let middle = 0.5 * (inside + outside);
                    if beyond(middle, 0.0) {
                        outside = middle;
                    } else {
                        inside = middle;
                    }
                }
                return Some(((1.0 - inside) * h, element));
            }
            from = to;
        }
        let ahead = usize::from(v1 > 0.0);
        let beyond = u1 - ends[ahead];
        let late = if beyond.abs() <= grain {
            0.0
        } else {
            beyond / v1
        };
        let element = elements[ahead].filter(|_| v1 != 0.0 && late.is_finite());
        element.map(|element| (late, element))
    }

    /// Goes to the element in a memory, where who reads which masters is found anew; false where there
    /// is no such element.
    pub(super) fn remember(&mut self, memory: &[f64]) -> bool {
        self.next = (0..self.places.len() - 1).find(|k| memory == [*k as f64]);
        self.next.is_some()
    }

    /// Goes on to the element that takes over, or behind whose end the frame is found, or to the charts
    /// that the beam has here.
    pub(super) fn hand_over(&mut self, q: &SVector<f64, 13>) -> ChartChanges {
        let (segment, sheets) = (self.segment, self.sheets);
        let (s, end) = (self.origin + q[12], self.lengths[self.lengths.len() - 1]);
        let inside = (self.lengths[segment] - s).max(s - self.lengths[segment + 1]) <= HAIR * end;
        self.segment = match self.next.take() {
            Some(next) => next,
            None if inside => segment,
            None => self.element_at(q[12]),
        };
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

/// The roots in (0, 1) of c + 2 b s + 3 a s², ascending.
fn turns(a: f64, b: f64, c: f64) -> impl IntoIterator<Item = f64> {
    let discriminant = b * b - 3.0 * a * c;
    // NaN where there are none: it is in no range.
    let sum = -(b + discriminant.sqrt().copysign(b));
    let (r, s) = (sum / (3.0 * a), c / sum);
    let within = |s: &f64| 0.0 < *s && *s < 1.0;
    [r.min(s), r.max(s)].into_iter().filter(move |s| within(s))
}

/// Ψ, or its complement.
pub(super) fn on<S: Scalar>(sheet: Sheet, psi: &Vector3<S>) -> Vector3<S> {
    match sheet {
        Sheet::Same => *psi,
        Sheet::Opposite => complement(psi),
    }
}

/// The rotation vector between those of the two ends, as the beam interpolates it: Σ Nᵢ Ψᵢ, or
/// log(R₁ exp(N₂ log(R₁ᵀ R₂))).
pub(super) fn between<S: Scalar>(
    interpolation: Interpolation,
    ends: [Vector3<S>; 2],
    shape: [S; 2],
) -> Vector3<S> {
    match interpolation {
        Interpolation::Total => ends[0] * shape[0] + ends[1] * shape[1],
        Interpolation::Geodesic => {
            let [p, r] = ends.each_ref().map(quaternion);
            let theta = log_quaternion(&p.conjugate().product(&r));
            log_quaternion(&p.product(&quaternion(&(theta * shape[1]))))
        }
    }
}
