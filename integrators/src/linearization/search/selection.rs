//! Which eigenvalues of the operator belong to the modes selected, and when they are enough.

use super::super::finish::ROUNDING;
use super::{EQUAL, Inner, Order, RitzPair, Search, Selection};
use num_complex::Complex64;

/// Largest residual of a converged eigenvalue of the operator, relative to it.
const CONVERGED: f64 = 1e-10;
/// The same, relative to the largest eigenvalue: rounding errors of the solver.
const FLOOR: f64 = 1e-15;
/// Eigenvalues of the operator below this part of the largest belong to infinite ones.
pub(super) const FINITE: f64 = 1e-13;
/// Residual, relative to the eigenvalue of the operator, of a pair that is no approximation although this many smaller ones have
/// converged.
pub(super) const WANDERING: f64 = 1e-2;
const INNER: usize = 4;
/// Part of ω² by which a range is wider than requested.
const ENDS: f64 = 1e-9;
/// Eigenvalues below this part of the shift are rounding errors.
const LOST: f64 = 64.0 * ROUNDING;
/// Ratio of the eigenvalues of the operator above which another shift is taken.
const SPREAD: f64 = 1e9;
/// The same with damping, where shapes lose as many digits.
const SPREAD_DAMPED: f64 = 1e6;

/// Shift with damping, relative to the last mode.
pub(super) const BETWEEN: f64 = 0.5;

impl Search<'_> {
    /// ω² or λ of an eigenvalue of the operator; zero where nothing but rounding errors are left.
    pub(super) fn eigenvalue(&self, pair: &RitzPair) -> Complex64 {
        let shift = self.operator.shift();
        match shift + pair.theta.inv() {
            value if value.norm() <= LOST * shift.abs() => Complex64::ZERO,
            value => value,
        }
    }

    /// A shift that suits the modes better: nearer to them, or farther from a low one that drowns them.
    pub(super) fn better_shift(&self, pairs: &[RitzPair]) -> Option<f64> {
        let Selection::Nearest { count, omega: 0.0 } = self.selection else {
            return None;
        };
        if self.inner == Inner::Stiffness {
            return None;
        }
        let shift = self.operator.shift();
        let first = pairs.first()?;
        let largest = first.theta.norm();
        let finite = pairs.partition_point(|p| p.theta.norm() > FINITE * largest);
        let wanted = self.position(pairs, count);
        let known = wanted.min(finite.saturating_sub(1));
        let last = match known == wanted || shift != 0.0 {
            true => self.eigenvalue(&pairs[known]).norm(),
            // One at rest but for rounding errors may leave nothing of the others.
            false => self.largest(),
        };
        let (part, spread) = match self.order {
            Order::Squares => (-0.25, SPREAD),
            Order::Quadratic => (BETWEEN, SPREAD_DAMPED),
        };
        let better = match shift == 0.0 {
            // Between the first and the last, whose errors are alike there.
            true => {
                let mean = (self.eigenvalue(first).norm() * last).sqrt();
                f64::signum(part) * mean.max(last / spread)
            }
            false => part * last,
        };
        let drowned = shift == 0.0 && largest * last > spread;
        let far = shift != 0.0 && better.abs() < 0.1 * shift.abs() && last > 1e-9 * shift.abs();
        ((drowned || far) && better.is_finite()).then_some(better)
    }

    /// Distance of the frequency of a pair from a circular frequency.
    pub(super) fn distance(&self, pair: &RitzPair, omega: f64) -> f64 {
        let size = self.eigenvalue(pair).norm();
        let frequency = match self.order {
            Order::Squares => size.sqrt(),
            Order::Quadratic => size,
        };
        (frequency - omega).abs()
    }

    /// Position of the pair that makes `count` modes, counting conjugate pairs once.
    pub(super) fn position(&self, pairs: &[RitzPair], count: usize) -> usize {
        let mut upper = pairs.iter().enumerate().filter(|(_, p)| self.is_upper(p));
        upper.nth(count - 1).map_or(pairs.len(), |(k, _)| k)
    }

    /// Whether a pair is one of those with Im λ ≥ 0.
    pub(super) fn is_upper(&self, pair: &RitzPair) -> bool {
        self.order == Order::Squares || pair.theta.im <= 0.0
    }

    /// Number of converged eigenvalues, from the largest of the operator on. Those of infinite eigenvalues
    /// are zero, and end the list.
    pub(super) fn converged(&self, pairs: &[RitzPair]) -> usize {
        let largest = pairs.first().map_or(0.0, |p| p.theta.norm());
        let small = |p: &&RitzPair| is_converged(p, largest);
        pairs.iter().take_while(small).count()
    }

    /// The pairs without those that are no approximations. Outer eigenvalues converge first; where the operator is not normal,
    /// one with a large residual may wander among them.
    pub(super) fn without_wandering(&self, mut pairs: Vec<RitzPair>) -> Vec<RitzPair> {
        let largest = pairs.first().map_or(0.0, |p| p.theta.norm());
        let converged: Vec<bool> = pairs.iter().map(|p| is_converged(p, largest)).collect();
        let mut inner = converged.iter().filter(|x| **x).count();
        let mut known = converged.iter();
        pairs.retain(|p| {
            inner -= usize::from(known.next() == Some(&true));
            self.is_symmetric() || inner < INNER || p.residual < WANDERING * p.theta.norm()
        });
        if !self.is_symmetric() {
            // An eigenvalue is known up to its residual. Of copies of one, as of many equal blades, those that have converged
            // come first.
            let copies = |p: &RitzPair, next: &RitzPair| {
                let [size, other] = [p, next].map(|p| p.theta.norm());
                size - other <= p.residual.max(CONVERGED * size).min(EQUAL * size)
            };
            for same in pairs.chunk_by_mut(copies) {
                same.sort_by_key(|p| !is_converged(p, largest));
            }
        }
        pairs
    }

    /// Number of the converged pairs that are needed, if they are enough.
    pub(super) fn wanted(&self, converged: &[RitzPair], expected: Option<usize>) -> Option<usize> {
        let reach = converged.last().map_or(0.0, |p| self.eigenvalue(p).norm());
        match (self.selection, self.order) {
            (Selection::Nearest { count, omega: 0.0 }, _) => {
                let k = self.position(converged, count) + 1;
                (k <= converged.len()).then_some(k)
            }
            (Selection::Nearest { count, omega }, order) => {
                let mut far: Vec<f64> = (converged.iter().filter(|p| self.is_upper(p)))
                    .map(|p| self.distance(p, omega))
                    .collect();
                far.sort_by(f64::total_cmp);
                let most = *far.get(count - 1)?;
                // All up to this distance have converged: of λ those around zero, of ω² those around the shift.
                let within = match order {
                    Order::Squares => most * (2.0 * omega + most),
                    Order::Quadratic => omega + most,
                };
                let inside = |p: &&RitzPair| match order {
                    Order::Squares => p.theta.norm().recip() <= within,
                    Order::Quadratic => self.eigenvalue(p).norm() <= within,
                };
                let k = converged.iter().take_while(inside).count() + 1;
                (k <= converged.len()).then_some(k)
            }
            (Selection::Range([_, to]), Order::Quadratic) => {
                (reach > to).then_some(converged.len())
            }
            (Selection::Range([_, to]), Order::Squares) => match expected {
                Some(expected) => (self.inside(converged) >= expected).then_some(converged.len()),
                // By |λ|, from zero on.
                None => (reach > to * to).then_some(converged.len()),
            },
        }
    }

    pub(super) fn is_in_range(&self, pair: &RitzPair) -> bool {
        let Selection::Range([from, to]) = self.selection else {
            return true;
        };
        let value = self.eigenvalue(pair);
        let square = match self.order {
            Order::Squares => value.norm(),
            Order::Quadratic => value.norm_sqr(),
        };
        let [from, to] = squares([from, to]);
        (from..=to).contains(&square)
    }

    /// Number of pairs in the range.
    pub(super) fn inside(&self, pairs: &[RitzPair]) -> usize {
        pairs.iter().filter(|p| self.is_in_range(p)).count()
    }
}

/// A range of ω², with the frequencies at its ends; rigid modes, zero but for rounding errors, lie in a range from zero.
pub(super) fn squares([from, to]: [f64; 2]) -> [f64; 2] {
    let square = to * to;
    let least = match from > 0.0 {
        true => from * from * (1.0 - ENDS),
        false => -ENDS * square,
    };
    [least, square * (1.0 + ENDS)]
}

/// Whether a pair has converged, given the largest eigenvalue of the operator.
fn is_converged(pair: &RitzPair, largest: f64) -> bool {
    let size = pair.theta.norm();
    pair.residual <= CONVERGED * size + FLOOR * largest && size > FINITE * largest
}
