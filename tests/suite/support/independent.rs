//! What the tests that solve cases of the gallery by other means share.

use super::program::assert_close;
use pullback::studies::gallery::{self, CaseRow};

/// The rows of a case.
pub fn rows(case: &str) -> Vec<CaseRow> {
    gallery::run(&[case.to_owned()], None, &mut |_| {}).unwrap()
}

/// The numbers that the rows whose quantity begins so compare with are these.
pub fn assert_published(rows: &[CaseRow], what: &str, limit: &[f64], within: f64) {
    let given = rows.iter().filter(|r| r.quantity.starts_with(what));
    let given: Vec<f64> = given.map(|r| r.published).collect();
    assert_eq!(given.len(), limit.len(), "{what}");
    for (given, limit) in given.iter().zip(limit) {
        assert_close(*limit, *given, within, what);
    }
}
