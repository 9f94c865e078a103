//! Ratios of times that do not depend on a machine's clock, which changes within a run: the two sides take
//! turns in short rounds, and the middle one of their ratios counts.

use std::time::Instant;

const ROUNDS: usize = 201;
/// Seconds of one side of a round, at least.
const SHORT: f64 = 5e-5;

/// How many times as long as the first the second takes.
pub fn race(mut first: impl FnMut(), mut second: impl FnMut()) -> f64 {
    let counts = [count(&mut first), count(&mut second)];
    let mut ratios: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let one = seconds(counts[0], &mut first) / counts[0] as f64;
            let other = seconds(counts[1], &mut second) / counts[1] as f64;
            other / one
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    ratios[ROUNDS / 2]
}

/// How many calls take [`SHORT`].
fn count(f: &mut impl FnMut()) -> usize {
    let mut count = 1;
    while seconds(count, f) < SHORT {
        count *= 2;
    }
    count
}

fn seconds(count: usize, f: &mut impl FnMut()) -> f64 {
    let start = Instant::now();
    (0..count).for_each(|_| f());
    start.elapsed().as_secs_f64()
}
