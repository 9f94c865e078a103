//! The laws of a scheme of order five.

use crate::support::dynamics::*;
use crate::support::*;
use pullback_conformance as check;

/// Radau IIA of three stages, of order 5 (Hairer & Wanner 1996, table IV.5.6), with this claim.
fn radau(order: usize) -> Scheme {
    let s = 6.0_f64.sqrt();
    let rows = [
        [
            0.0,
            (88.0 - 7.0 * s) / 360.0,
            (296.0 - 169.0 * s) / 1800.0,
            (-2.0 + 3.0 * s) / 225.0,
        ],
        [
            0.0,
            (296.0 + 169.0 * s) / 1800.0,
            (88.0 + 7.0 * s) / 360.0,
            (-2.0 - 3.0 * s) / 225.0,
        ],
        [0.0, (16.0 - s) / 36.0, (16.0 + s) / 36.0, 1.0 / 9.0],
    ];
    let times = [(4.0 - s) / 10.0, (4.0 + s) / 10.0, 1.0];
    let stages = Stage::runge_kutta(times, rows);
    let scheme = Scheme::new("Radau IIA", &stages, stable(order)).unwrap();
    scheme.under_multipliers([5, 3])
}

#[test]
fn orders_are_measured_above_rounding() {
    check::scheme(&radau(5)).assert();
}

#[test]
fn an_order_too_high_is_found() {
    let laws = check::scheme(&radau(6)).failing_laws();
    for law in ["order", "order under changes of chart"] {
        assert!(laws.contains(&law.to_owned()), "{laws:?}");
    }
}
