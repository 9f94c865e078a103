//! Times at which a step must end: kinks of functions of time, and the end.

use pullback_manifold::system::System;

/// A time at which a step must end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stop {
    /// Where the step ends, and where the next one begins: the same but for rounding errors in
    /// times that are meant to be equal.
    pub left: f64,
    pub right: f64,
    /// Whether functions of time have a kink or jump there.
    pub kink: bool,
}

impl Stop {
    pub(super) fn end(t: f64) -> Self {
        Self {
            left: t,
            right: t,
            kink: false,
        }
    }
}

/// All kinks, ascending.
pub(super) fn kinks<Y: System + ?Sized>(system: &Y) -> Vec<f64> {
    let mut kinks = system.kinks();
    kinks.sort_by(f64::total_cmp);
    kinks
}

/// Kinks after the start and until the end, and the end, ascending.
pub(super) fn stops(kinks: &[f64], from: f64, to: f64) -> Vec<Stop> {
    let slack = 1e-13 * to.abs().max(from.abs());
    let within = |t: &f64| *t > from + slack && *t <= to + slack;
    let mut stops: Vec<Stop> = Vec::new();
    for t in kinks.iter().copied().filter(within) {
        match stops.last_mut() {
            Some(last) if t - last.right <= slack => last.right = t,
            _ => stops.push(Stop {
                left: t,
                right: t,
                kink: true,
            }),
        }
    }
    match stops.last_mut() {
        Some(last) if to - last.left <= slack => last.left = to,
        _ => stops.push(Stop::end(to)),
    }
    stops
}
