//! The heavy top held by multipliers, in every method that takes them.

use crate::support::heavy_top::{HELD, assert_heavy_top};

#[test]
fn it_is_where_it_should_be() {
    let second = ["ga:0.8", "lie-ga:0.8", "ul-ga:0.8"].map(|m| (m, 2));
    assert_heavy_top(HELD, &[&second[..], &[("radau", 3)]].concat());
}
