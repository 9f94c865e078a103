//! Cases of the gallery meet every published or exact value.

use crate::support::gallery::assert_computed;
use pullback::studies::gallery;

/// Cases of seconds each, which `tests/studies` runs with all others.
const LONG: [&str; 11] = [
    "arm-spherical",
    "arm-revolute",
    "bricard",
    "double-pendulum",
    "four-bar",
    "four-bar-flexible",
    "four-bar-misaligned",
    "helix",
    "parallelograms",
    "slider-crank",
    "squeezer",
];

#[test]
fn short_cases_meet_their_tolerances_and_none_is_lost_or_loosened() {
    let all = gallery::case_names();
    let short: Vec<&str> = all.filter(|c| !LONG.contains(c)).collect();
    assert_computed(&short, "gallery");
}
