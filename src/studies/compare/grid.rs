//! Step sizes as numbers of equal steps, and the common times of all runs.

use super::CompareError;

/// Most common times.
const MOST_TIMES: usize = 128;
/// Sufficient common times, for which step sizes are not rounded.
const ENOUGH_TIMES: usize = 10;
/// Common times below which step sizes are rounded further.
const FEW_TIMES: usize = 4;
/// Relative increase of numbers of steps by rounding.
const LITTLE: f64 = 0.01;
const MUCH: f64 = 0.25;
/// Largest number of steps; the reference makes eight times as many.
const MOST_STEPS: f64 = 1e8;

/// The times of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Grid {
    /// The duration.
    pub to: f64,
    /// Number of steps for each step size, ascending.
    pub counts: Vec<usize>,
    /// Number of common times, equally spaced, the last one the end; it divides every count.
    pub times: usize,
}

impl Grid {
    /// Checks step sizes, from large to small.
    ///
    /// A step size becomes the smallest number of equal steps that are not larger. With too few common times these
    /// numbers are rounded up a little, or more if necessary.
    pub fn new(to: f64, steps: &[f64]) -> Result<Self, CompareError> {
        for &value in steps {
            if !(value > 0.0 && value.is_finite()) {
                return Err(CompareError::Step { value });
            }
            if value > to * (1.0 + 1e-9) {
                return Err(CompareError::Long { value, to });
            }
            if to / value > MOST_STEPS {
                let most = MOST_STEPS;
                return Err(CompareError::Many { value, most });
            }
        }
        if let Some(pair) = steps.windows(2).find(|pair| pair[1] >= pair[0]) {
            let [before, after] = [pair[0], pair[1]];
            return Err(CompareError::Order { before, after });
        }
        if steps.len() < 2 {
            let found = steps.len();
            return Err(CompareError::FewSteps { found });
        }
        let count = |h: &f64| (to / h - 1e-6).ceil().max(1.0) as usize;
        let counts: Vec<usize> = steps.iter().map(count).collect();
        if counts[0] < 2 {
            return Err(CompareError::OneStep { value: steps[0] });
        }
        if let Some(k) = counts.windows(2).position(|n| n[0] >= n[1]) {
            let ([before, after], count) = ([steps[k], steps[k + 1]], counts[k]);
            return Err(CompareError::Close {
                before,
                after,
                count,
            });
        }
        let rounded = |times: usize| -> Vec<usize> {
            counts.iter().map(|n| n.next_multiple_of(times)).collect()
        };
        let close = |rounded: &[usize], part: f64| {
            let pairs = rounded.iter().zip(&counts);
            let mut parts = pairs.map(|(more, n)| (more - n) as f64 / *n as f64);
            parts.all(|p| p <= part) && rounded.windows(2).all(|n| n[0] < n[1])
        };
        let most = |from: usize, to: usize, part: f64| {
            let times = (from..=to).rev();
            times.map(|m| (m, rounded(m))).find(|(_, n)| close(n, part))
        };
        let found = most(ENOUGH_TIMES, MOST_TIMES, 0.0)
            .or_else(|| most(FEW_TIMES, MOST_TIMES, LITTLE))
            .or_else(|| most(1, 2 * FEW_TIMES, MUCH));
        let (times, counts) = found.unwrap_or((1, counts));
        Ok(Self { to, counts, times })
    }

    /// The largest step over this multiple (1 or more) of the duration, or a little longer if the numbers of
    /// steps have too few divisors for common times.
    ///
    /// # Errors
    /// [`CompareError::TooLong`].
    pub fn longer(&self, factor: f64) -> Result<Self, CompareError> {
        let count = self.counts[0];
        if count as f64 * factor > MOST_STEPS {
            let (value, most) = (factor, MOST_STEPS);
            return Err(CompareError::TooLong { value, most });
        }
        let steps = (count as f64 * factor).ceil() as usize;
        let mut exact = (ENOUGH_TIMES..=MOST_TIMES).rev();
        let times = exact.find(|m| steps.is_multiple_of(*m));
        let times = times.unwrap_or(steps.min(MOST_TIMES));
        let steps = steps.next_multiple_of(times);
        Ok(Self {
            to: self.step(count) * steps as f64,
            counts: vec![steps],
            times,
        })
    }

    /// All common times, the start first.
    pub fn all_times(&self) -> Vec<f64> {
        let part = |k: usize| k as f64 / self.times as f64;
        (0..=self.times).map(|k| self.to * part(k)).collect()
    }

    /// The size of this number of equal steps.
    pub fn step(&self, count: usize) -> f64 {
        self.to / count as f64
    }

    /// Number of steps of the finest run.
    pub fn finest(&self) -> usize {
        self.counts.last().copied().unwrap_or(1)
    }
}
