//! Cases of the gallery meet every published or exact value.

use crate::support::gallery::assert_computed;
use pullback::studies::gallery;

/// Cases of seconds each, which `tests/studies` runs with all others.
const LONG: [&str; 7] = [
    "arm-spherical",
    "arm-revolute",
    "four-bar",
    "slider-crank",
    "parallelograms",
    "squeezer",
    "bricard",
];

#[test]
fn short_cases_meet_their_tolerances_and_none_is_lost_or_loosened() {
    let all = gallery::CASES.iter().map(|c| c.name);
    let short: Vec<&str> = all.filter(|c| !LONG.contains(c)).collect();
    assert_computed(&short, "gallery");
}

#[test]
fn a_miss_is_seen() {
    let rows = gallery::run(&["bend45".to_owned()], None, &mut |_| {}).unwrap();
    let mut row = rows[0].clone();
    assert!(row.passed());
    row.difference = 2.0 * row.tolerance;
    assert!(!row.passed());
    row.difference = f64::NAN;
    assert!(!row.passed());
}

#[test]
fn an_unknown_case_is_refused_with_the_known_ones() {
    let error = gallery::run(&["bend46".to_owned()], None, &mut |_| {}).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("bend46") && text.contains("bend45"), "{text}");
}
