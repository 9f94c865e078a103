//! All cases of the gallery.

use crate::support::gallery::assert_bounded;
use pullback::studies::gallery;

#[test]
fn every_case_meets_its_tolerances_and_none_is_lost_or_loosened() {
    let all: Vec<&str> = gallery::CASES.iter().map(|c| c.name).collect();
    assert_bounded(&all, "whole_gallery");
}
