//! Errors over step size and over cost: observed orders with their confidence, and errors at equal cost.

use pullback::solve::Counts;
use pullback::studies::compare::{ComparisonRow, Drift, EqualCost, ErrorQuantity, Values, fit};

fn errors(error: impl Fn(f64) -> f64) -> Vec<(f64, Option<f64>)> {
    let steps = (0..6).map(|k| 0.1 / f64::from(1 << k));
    steps.map(|h| (h, Some(error(h)))).collect()
}

#[test]
fn a_pure_power_gives_its_order_with_certainty() {
    let fit = fit(&errors(|h| 3.0 * h.powi(2)), 0.0).unwrap();
    assert!((fit.order - 2.0).abs() < 1e-12 && fit.points == 6);
    assert!(fit.confidence.unwrap() < 1e-12);
}

#[test]
fn what_is_not_asymptotic_or_too_near_the_reference_is_left_out() {
    // Order 2 from 0.05 on; the three finest at the level of the reference.
    let mut e = errors(|h| h * h + 1e-6);
    e[0].1 = Some(1.0);
    let found = fit(&e, 2e-5).unwrap();
    assert_eq!((found.points, found.confidence), (2, None));
    assert_eq!(found.steps.map(|h| (1e4 * h).round()), [500.0, 250.0]);
    let failed = [(0.1, None), (0.05, Some(1.0)), (0.025, None)];
    assert_eq!(fit(&failed, 0.0), None);
}

#[test]
fn students_quantiles_are_those_of_the_tables() {
    // 95 %, two-sided, of degrees of freedom.
    for (freedom, t) in [(1, 12.706), (11, 2.201), (20, 2.086), (30, 2.042)] {
        // A line of slope 2 through two points more, each second one lifted by δ.
        let (count, delta) = (freedom + 2, 0.05);
        let x = |k: usize| -(k as f64);
        let lift = |k: usize| if k.is_multiple_of(2) { 0.0 } else { delta };
        let e = (0..count).map(|k| (x(k).exp(), Some((2.0 * x(k) + lift(k)).exp())));
        let fit = fit(&e.collect::<Vec<_>>(), 0.0).unwrap();
        assert_eq!(fit.points, count);
        // The standard error of the slope by the sums of the textbook, of x and lifts from their means.
        let n = count as f64;
        let sum = |f: &dyn Fn(usize) -> f64| (0..count).map(f).sum::<f64>();
        let (mean_x, mean) = (sum(&x) / n, sum(&lift) / n);
        let xx = sum(&|k| (x(k) - mean_x).powi(2));
        let xy = sum(&|k| (x(k) - mean_x) * (lift(k) - mean));
        let yy = sum(&|k| (lift(k) - mean).powi(2));
        let standard = ((yy - xy * xy / xx) / freedom as f64 / xx).sqrt();
        let found = fit.confidence.unwrap() / standard;
        assert!((found - t).abs() < 1e-3, "{freedom}: {found}");
    }
}

/// A run of a cost in seconds with the same error in all quantities.
fn row(scheme: &str, (cost, error): (f64, f64)) -> ComparisonRow {
    ComparisonRow {
        scheme: scheme.to_owned(),
        requested_step: 0.1,
        step: 0.1,
        failure: None,
        counts: Counts::default(),
        assemblies: 0,
        searching: 0,
        error: Some(Values([error; ErrorQuantity::ALL.len()])),
        drift: Drift::default(),
        seconds: cost,
        seconds_alone: Some(cost),
        samples: Vec::new(),
    }
}

/// The error in a quantity of runs (cost, error) beside two others that make this the cost of the
/// comparison: the middle of the common range in logarithms, or of the gap if there is none.
fn at(runs: &[(f64, f64)], cost: f64, quantity: ErrorQuantity) -> f64 {
    let (first, last) = (runs[0].0, runs[runs.len() - 1].0);
    let others = if cost < first {
        let end = cost * cost / first;
        [0.5 * end, end]
    } else if cost > last {
        let start = cost * cost / last;
        [start, 2.0 * start]
    } else {
        let ratio = f64::min(cost / first, last / cost);
        [cost / ratio, cost * ratio]
    };
    let mut rows: Vec<ComparisonRow> = runs.iter().map(|&run| row("own", run)).collect();
    rows.extend(others.map(|cost| row("other", (cost, 1.0))));
    let names = ["own", "other"].map(str::to_owned);
    let found = EqualCost::find(&names, &rows, None, true).unwrap();
    assert!((found.cost / cost - 1.0).abs() < 1e-12 && found.seconds);
    let (name, errors, extrapolated) = &found.schemes[0];
    assert_eq!(name, "own");
    assert_eq!(*extrapolated, !(first..=last).contains(&cost));
    errors.of(quantity)
}

#[test]
fn errors_lie_on_the_line_through_the_nearest_runs() {
    // Error 1/c² up to c = 2, and 2/c³ from there.
    let runs = [(1.0, 1.0), (2.0, 0.25), (4.0, 0.031_25)];
    for (cost, error) in [
        (0.5, 4.0),
        (1.5, 1.0 / 2.25),
        (3.0, 2.0 / 27.0),
        (8.0, 2.0 / 512.0),
    ] {
        let found = at(&runs, cost, ErrorQuantity::Rotation);
        assert!((found / error - 1.0).abs() < 1e-12, "{cost}: {found}");
    }
    // Twice the steps in nearly the same time are not extrapolated.
    let noise = [(1.0, 1.0), (2.0, 0.25), (2.02, 0.0625)];
    assert!(at(&noise, 4.0, ErrorQuantity::Rotation).is_nan());
    assert!(at(&noise, 2.01, ErrorQuantity::Rotation).is_finite());
    // Errors of zero have no logarithm.
    let none = [(1.0, 0.0), (2.0, 0.0)];
    assert!(at(&none, 1.5, ErrorQuantity::Position).is_nan());
}
