//! The runs of a comparison: step sizes as numbers of equal steps, common times, and threads.

use crate::support::laboratory::{compared, model, options, until};
use pullback::input;
use pullback::studies::compare::{
    CompareError, Comparison, ComparisonOptions, Exact, Hooks, Sample, compare,
};
use std::num::NonZeroUsize;
use std::sync::{Condvar, Mutex};
use std::time::Duration;

/// Runs of a free body, with nothing to compare with.
fn asked(schemes: &[&str], steps: &[f64]) -> ComparisonOptions {
    ComparisonOptions {
        exact: Some(Exact::new("nothing known", |_: &mut Sample| {})),
        ..options(schemes, steps)
    }
}

fn ran(to: f64, steps: &[f64]) -> Comparison {
    let file = until(model("free_body.toml"), to);
    compared(&file, &asked(&["newmark"], steps)).unwrap()
}

#[test]
fn runs_meet_at_common_times() {
    for (to, steps, counts, times) in [
        (1.0, [0.1, 0.05, 0.025], [10, 20, 40], 10),
        // Steps with common times are made as given.
        (4.0, [0.04, 0.02, 0.01], [100, 200, 400], 100),
        // 187.5 steps make 188, and 94 common times cost three in a thousand of the others.
        (1.5, [0.008, 0.004, 0.002], [188, 376, 752], 94),
        // 10, 13 and 17 steps would meet at the end only.
        (1.0, [0.1, 0.077, 0.06], [10, 15, 20], 5),
    ] {
        let comparison = ran(to, &steps);
        let made: Vec<usize> = comparison.rows.iter().map(|r| r.counts.steps).collect();
        assert_eq!((&made[..], comparison.times), (&counts[..], times));
        for (row, count) in comparison.rows.iter().zip(counts) {
            assert_eq!(row.step, to / count as f64);
            assert_eq!(row.samples.len(), times + 1);
            assert!(row.error.unwrap().0.iter().all(|error| error.is_nan()));
        }
    }
    let comparison = ran(1.0, &[0.1, 0.05]);
    let row = &comparison.rows[0];
    assert_eq!((row.samples[5].t, row.samples[10].t), (0.5, 1.0));
}

#[test]
fn a_longer_run_has_the_largest_step() {
    let file = until(model("free_body.toml"), 1.0);
    let longer = |factor: f64| {
        let long = Some(factor);
        let asked = asked(&["newmark"], &[0.1, 0.05]);
        compared(&file, &ComparisonOptions { long, ..asked })
    };
    let error = longer(1e300).unwrap_err();
    assert!(matches!(error, CompareError::TooLong { .. }), "{error}");
    let comparison = longer(20.0).unwrap();
    let [row] = &comparison.long[..] else {
        panic!("{} long runs", comparison.long.len());
    };
    assert_eq!((row.counts.steps, row.samples.len()), (200, 100 + 1));
    assert!((row.step - 0.1).abs() < 1e-15);
    assert!((row.samples[100].t - 20.0).abs() < 1e-12);
}

#[test]
fn as_many_runs_as_threads_are_under_way_at_once() {
    let file = until(model("free_body.toml"), 1.0);
    let own = std::thread::current().id();
    for (threads, together) in [(1, 1), (3, 3), (9, 4)] {
        let (under_way, changed) = (Mutex::new((0, 0)), Condvar::new());
        let make = |formulation| {
            // What is built before the runs is built here.
            if std::thread::current().id() != own {
                let mut count = under_way.lock().unwrap();
                count.0 += 1;
                count.1 = count.1.max(count.0);
                changed.notify_all();
                // Waits for the others, with a timeout.
                let wait = Duration::from_secs(if together == 1 { 0 } else { 20 });
                let waiting = changed.wait_timeout_while(count, wait, |c| c.1 < together);
                waiting.unwrap().0.0 -= 1;
            }
            input::job("model.toml", &file, Some(formulation))
        };
        let asked = ComparisonOptions {
            threads: NonZeroUsize::new(threads),
            ..asked(&["newmark", "ga:0.8"], &[0.1, 0.05])
        };
        let comparison = compare(&make, "model.toml", &asked, &Hooks::NONE).unwrap();
        assert_eq!(under_way.into_inner().unwrap().1, together);
        assert_eq!(comparison.threads, together);
        let made = comparison.rows.iter();
        let made: Vec<_> = made
            .map(|r| (&r.scheme[..], r.counts.steps, &r.failure))
            .collect();
        let both = ["newmark", "ga:0.8"].map(|scheme| [10, 20].map(|n| (scheme, n, &None)));
        assert_eq!(made, both.concat());
    }
}
