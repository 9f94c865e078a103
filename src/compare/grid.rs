//! Step sizes as numbers of equal steps, and the times at which all runs meet.

use super::CompareError;

/// Common times at most: enough to see a motion, and little to keep.
const MOST_TIMES: usize = 128;
/// Common times that step sizes are rounded for, where they have no more of their own.
const FEW_TIMES: usize = 8;
/// More steps than a user would wait for; the reference makes eight times as many.
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
    /// A step size becomes the number of equal steps that are at most so large. Where these
    /// numbers have too few divisors in common they are rounded up, which makes steps smaller.
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
        for pair in steps.windows(2) {
            let [before, after] = [pair[0], pair[1]];
            if after >= before {
                return Err(CompareError::Order { before, after });
            }
        }
        if steps.len() < 2 {
            let found = steps.len();
            return Err(CompareError::FewSteps { found });
        }
        let count = |h: &f64| (to / h - 1e-6).ceil().max(1.0) as usize;
        let mut counts: Vec<usize> = steps.iter().map(count).collect();
        let mut common = counts.iter().copied().fold(0, gcd);
        let wanted = FEW_TIMES.min(counts[0]);
        if common < wanted {
            counts
                .iter_mut()
                .for_each(|n| *n = n.next_multiple_of(wanted));
            common = counts.iter().copied().fold(0, gcd);
        }
        for (k, pair) in counts.windows(2).enumerate() {
            if pair[0] == pair[1] {
                let ([before, after], count) = ([steps[k], steps[k + 1]], pair[0]);
                return Err(CompareError::Close {
                    before,
                    after,
                    count,
                });
            }
        }
        let times = (1..=common.min(MOST_TIMES))
            .rev()
            .find(|d| common.is_multiple_of(*d));
        Ok(Self {
            to,
            counts,
            times: times.unwrap_or(1),
        })
    }

    /// Common time `k`, from 1.
    pub fn time(&self, k: usize) -> f64 {
        if k >= self.times {
            self.to
        } else {
            self.to * (k as f64 / self.times as f64)
        }
    }

    /// The size of so many equal steps.
    pub fn step(&self, count: usize) -> f64 {
        self.to / count as f64
    }

    /// Number of steps of the finest run.
    pub fn finest(&self) -> usize {
        self.counts.last().copied().unwrap_or(1)
    }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn runs_meet_at_common_times() {
        let grid = Grid::new(1.0, &[0.1, 0.05, 0.025]).unwrap();
        assert_eq!(
            (grid.counts.as_slice(), grid.times),
            (&[10, 20, 40][..], 10)
        );
        assert_eq!((grid.time(5), grid.time(10)), (0.5, 1.0));
        // 10, 15 and 20 steps would meet at five times only.
        let grid = Grid::new(1.0, &[0.1, 0.07, 0.05]).unwrap();
        assert_eq!((grid.counts.as_slice(), grid.times), (&[16, 24, 32][..], 8));
    }
}
