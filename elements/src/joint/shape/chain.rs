//! Chains of straight lines, for slides.

use nalgebra::Vector3;
use pullback_manifold::scalar::Scalar;

/// Excursion beyond an end, relative to the length of the chain, that counts as rounding.
const GRAIN: f64 = 4e-15;
/// Excursion beyond the end of a line, relative to the length of the chain, that does not change the line.
const HAIR: f64 = 1e-8;

/// A chain of straight lines with the arc length u (L) from its origin as parameter. The present line
/// changes where u passes an end of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// The positions that the lines connect, and their arc lengths.
    positions: Vec<Vector3<f64>>,
    lengths: Vec<f64>,
    /// Where u = 0: arc length from the beginning of the chain, and position.
    origin: f64,
    start: Vector3<f64>,
    line: usize,
    /// The next line, if it is known.
    next: Option<usize>,
}

impl Chain {
    /// A chain through these positions with u = 0 at the arc length `origin`; `None` if there are fewer
    /// than two positions, neighbours coincide, or `origin` is outside the chain.
    pub fn new(positions: &[Vector3<f64>], origin: f64) -> Option<Self> {
        let mut lengths = vec![0.0];
        for pair in positions.windows(2) {
            let length = (pair[1] - pair[0]).norm();
            if length.is_nan() || length <= 0.0 {
                return None;
            }
            lengths.push(lengths[lengths.len() - 1] + length);
        }
        let end = *lengths.last()?;
        if positions.len() < 2 || !(0.0..=end).contains(&origin) {
            return None;
        }
        let mut chain = Self {
            positions: positions.to_vec(),
            lengths,
            origin,
            start: Vector3::zeros(),
            line: 0,
            next: None,
        };
        chain.line = chain.line_at(0.0);
        chain.start = chain.displacement(0.0);
        Some(chain)
    }

    /// The position at u = 0.
    pub fn start(&self) -> Vector3<f64> {
        self.start
    }

    /// Displacement from u = 0 to u on the present line.
    pub fn displacement<S: Scalar>(&self, u: S) -> Vector3<S> {
        let [a, b] = self.shape(u);
        let position = |k: usize| self.positions[self.line + k].map(S::constant);
        position(0) * a + position(1) * b - self.start.map(S::constant)
    }

    /// Number of lines.
    pub fn count(&self) -> usize {
        self.positions.len() - 1
    }

    /// The present line, from 0.
    pub fn line(&self) -> usize {
        self.line
    }

    fn line_at(&self, u: f64) -> usize {
        let after = self.lengths.partition_point(|&s| s <= self.origin + u);
        after.clamp(1, self.positions.len() - 1) - 1
    }

    /// The weights of the ends of the present line.
    pub fn shape<S: Scalar>(&self, u: S) -> [S; 2] {
        let (from, to) = (self.lengths[self.line], self.lengths[self.line + 1]);
        let b = (u + (self.origin - from)) / (to - from);
        [S::one() - b, b]
    }

    /// Distance to the nearer end of the chain, with a tolerance that lets a joint rest there.
    pub fn room(&self, u: f64) -> f64 {
        let (s, end) = (self.origin + u, self.lengths[self.lengths.len() - 1]);
        s.min(end - s) + 1e-9 * end
    }

    /// First change of line in a step of size h, on the cubic between the states (u, u̇) at its ends: the
    /// time from the change to the end of the step, and the next line. Without a change in the step, the
    /// next one is extrapolated with the velocity at its end.
    pub fn leaves(&self, h: f64, [u0, v0]: [f64; 2], [u1, v1]: [f64; 2]) -> Option<(f64, usize)> {
        let k = self.line;
        let ends = [self.lengths[k], self.lengths[k + 1]].map(|s| s - self.origin);
        let after = (k + 2 < self.lengths.len()).then_some(k + 1);
        let lines = [k.checked_sub(1), after];
        // u0 + c s + b s² + a s³, s = 0 … 1.
        let du = u1 - u0;
        let (a, b) = (h * (v0 + v1) - 2.0 * du, 3.0 * du - h * (2.0 * v0 + v1));
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
            let moves = u(to) != u(from);
            let (end, sign) = if up { (ends[1], 1.0) } else { (ends[0], -1.0) };
            let beyond = |s: f64, by: f64| sign * (u(s) - end) > by;
            if let (true, Some(line)) = (moves && beyond(to, grain), lines[usize::from(up)]) {
                let (mut inside, mut outside) = (from, to);
                for _ in 0..f64::MANTISSA_DIGITS {
                    let middle = 0.5 * (inside + outside);
                    if beyond(middle, 0.0) {
                        outside = middle;
                    } else {
                        inside = middle;
                    }
                }
                return Some(((1.0 - inside) * h, line));
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
        let line = lines[ahead].filter(|_| v1 != 0.0 && late.is_finite());
        line.map(|line| (late, line))
    }

    /// Sets the next line; false if there is no such line.
    pub fn enter(&mut self, line: f64) -> bool {
        self.next = (0..self.positions.len() - 1).find(|k| line == *k as f64);
        self.next.is_some()
    }

    /// Changes to the next line if it is set, or to that of u; returns whether the line changes.
    pub fn change_segments(&mut self, u: f64) -> bool {
        let before = self.line;
        let (s, end) = (self.origin + u, self.lengths[self.lengths.len() - 1]);
        let inside = (self.lengths[before] - s).max(s - self.lengths[before + 1]) <= HAIR * end;
        self.line = match self.next.take() {
            Some(next) => next,
            None if inside => before,
            None => self.line_at(u),
        };
        self.line != before
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
