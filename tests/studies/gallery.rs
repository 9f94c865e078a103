//! All cases of the gallery.

use crate::support::gallery::{assert_bounded, assert_computed};
use crate::support::program::read;
use pullback::studies::gallery;
use std::path::Path;

/// Where `pullback gallery --json --out DIRECTORY > DIRECTORY/rows.json` has just run, nothing is computed
/// again: the variable `GALLERY` is that directory.
#[test]
fn every_case_meets_its_tolerances_and_none_is_lost_or_loosened() {
    let all: Vec<&str> = gallery::case_names().collect();
    let Some(written) = std::env::var_os("GALLERY") else {
        return assert_computed(&all, "whole_gallery");
    };
    let written = Path::new(&written);
    let rows: Vec<gallery::CaseRow> =
        serde_json::from_str(&read(written.join("rows.json"))).unwrap();
    assert_bounded(&all, &rows, written);
}
