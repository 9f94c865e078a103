//! What the tests that solve cases of the gallery by other means share.
#![allow(dead_code)]

use pullback::studies::gallery::CaseRow;

/// Value at no cell size from those of order two with some size and its half.
pub fn extrapolated<const N: usize>(coarse: [f64; N], fine: [f64; N]) -> [f64; N] {
    std::array::from_fn(|k| fine[k] + (fine[k] - coarse[k]) / 3.0)
}

/// The numbers that the rows whose quantity begins so compare with are these.
pub fn assert_published(rows: &[CaseRow], what: &str, limit: &[f64], within: f64) {
    let given = rows.iter().filter(|r| r.quantity.starts_with(what));
    let given: Vec<f64> = given.map(|r| r.published).collect();
    assert_eq!(given.len(), limit.len(), "{what}");
    for (given, limit) in given.iter().zip(limit) {
        assert!(
            (given - limit).abs() < within,
            "{what}: {limit} for {given}"
        );
    }
}
