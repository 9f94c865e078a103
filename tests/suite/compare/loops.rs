//! `compare` on loops: how they hold, orders with multipliers, and penalties whose vibrations no step resolves.

use crate::support::comparisons;
use crate::support::laboratory::options;
use crate::support::program::*;
use pullback::studies::compare::{
    Comparison, ComparisonOptions, ErrorQuantity, Sample, Slope, Values,
};

/// The four-bar linkage for a short time, its loop closed so.
fn four_bar(closure: &str, to: f64) -> String {
    let closure = closure.replace('\n', "\\n");
    let changes = format!("name = \"C\"\\n => &{closure}\\n\nto = 4\\n => to = {to}\\n");
    changed(&example("four_bar"), &changes)
}

fn compared(text: &str, words: &[&str], steps: &[f64]) -> Comparison {
    let options = ComparisonOptions {
        residual: Some(1e-12),
        ..options(words, steps)
    };
    comparisons::compared(text, &options).unwrap()
}

/// Root mean square of the distance of accelerations of positions.
fn apart(a: &[Sample], b: &[Sample]) -> f64 {
    let nodes = |s: &[Sample]| s.iter().flat_map(|s| s.nodes.clone()).collect::<Vec<_>>();
    let (a, b) = (nodes(a), nodes(b));
    assert_eq!(a.len(), b.len());
    let pairs = a.iter().zip(&b);
    let sum: f64 = pairs
        .map(|(a, b)| (a.acceleration - b.acceleration).norm_squared())
        .sum();
    (sum / a.len() as f64).sqrt()
}

/// Hairer, Lubich & Roche 1989: 2s − 1 and s for positions and velocities by Radau IIA with s stages at index 3.
#[test]
fn orders_with_multipliers_are_those_of_index_three() {
    let words = ["radau", "bathe", "ga:0.5"];
    let steps = [0.02, 0.01, 0.005];
    let comparison = compared(&four_bar("closure = \"multipliers\"", 0.4), &words, &steps);
    assert!(comparison.multipliers);
    let theory = [[3, 2, 2], [2, 2, 2], [2, 2, 2]];
    for (scheme, levels) in comparison.orders.iter().zip(theory) {
        assert_eq!(scheme.theory, Some(Values::of_levels(levels)));
        for (quantity, order) in [
            (ErrorQuantity::Velocity, levels[1]),
            (ErrorQuantity::AngularVelocity, levels[1]),
            (ErrorQuantity::Acceleration, levels[2]),
            (ErrorQuantity::AngularAcceleration, levels[2]),
        ] {
            let found = scheme.of(quantity).unwrap();
            let what = format!("{}, {}: {found:?}", scheme.scheme, quantity.name());
            assert!((found.order - order as f64).abs() < 0.15, "{what}");
            // The reference's accelerations are of order one before they are extrapolated: good enough for
            // the two larger steps of an order of two, which make no line.
            let few = found.points == 2 && order == 2;
            let seen = scheme.slope(quantity);
            assert!(seen == Some(Slope::Theory) || few, "{what}");
        }
    }
    // All of the reference is extrapolated, each quantity by its own order, and agrees with that of a loop
    // whose angles are a map, which has no multipliers.
    let reference = comparison.reference.as_ref().unwrap();
    assert_eq!(reference.extrapolated, Values([true; 7]));
    let mapped = compared(&four_bar("", 0.4), &["ga:0.5"], &steps);
    assert!(!mapped.multipliers);
    let other = mapped.reference.as_ref().unwrap();
    let gap = apart(&reference.samples, &other.samples);
    let allowed = [reference, other].map(|r| r.error.of(ErrorQuantity::Acceleration));
    assert!(gap <= allowed[0] + allowed[1], "{gap:e} {allowed:?}");
}

#[test]
fn residuals_of_loops_are_tabulated() {
    let linkage = |closure: &str| {
        let options = options(&["ga:0.8", "radau"], &[0.02, 0.01]);
        let comparison = comparisons::compared(&four_bar(closure, 0.2), &options).unwrap();
        let violations = comparison.rows.iter().map(|row| {
            assert_eq!(row.failure, None, "{closure}, {}", row.scheme);
            row.drift.violation.unwrap()
        });
        violations.fold(0.0, f64::max)
    };
    // What Newton's method leaves, and the compliance of the penalty, with forces of order 10.
    assert!(linkage("") < 1e-11);
    assert!(linkage("closure = \"multipliers\"") < 1e-9);
    let [soft, stiff] =
        ["1e5", "1e6"].map(|p| linkage(&format!("closure = \"penalty\"\npenalty = {p}")));
    assert!((0.05..0.2).contains(&(stiff / soft)), "{soft:e} {stiff:e}");
}

/// A stiff penalty vibrates; the scheme of the reference damps that away with large steps and less so with
/// small ones: its runs go apart.
#[test]
fn a_comparison_without_any_reference_says_so() {
    let text = four_bar("closure = \"penalty\"\npenalty = 1e7", 0.04);
    let comparison = compared(&text, &["ga:0.8"], &[0.004, 0.002]);
    assert!(!comparison.is_known() && comparison.reference_failure.is_none());
    let model = write(&directory("compare_loops"), &text);
    let ran = compare(&model, "--schemes ga:0.8 --steps 0.004,0.002");
    let said = ended(&ran, 1);
    let words = [
        "no reference for any quantity",
        "(observed orders −",
        "take smaller steps, or --reference bathe",
        "results are in ",
    ];
    assert_says(&said, &words);
    let page = read(model.with_extension("compare").join("compare.md"));
    assert_says(&page, &["No reference for any quantity"]);
}
