//! Times at which a step must end: kinks of functions of time, ends of intervals, and the end.

use super::DynamicOptions;
use crate::abilities::events;
use pullback_manifold::system::System;

/// A time at which a step must end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StopTime {
    /// End of the step, and beginning of the next one: equal but for rounding errors in times that
    /// are meant to be equal.
    pub left: f64,
    pub right: f64,
    /// Whether a function of time has a kink or jump there.
    pub kink: bool,
}

impl StopTime {
    pub(super) fn end(t: f64) -> Self {
        Self {
            left: t,
            right: t,
            kink: false,
        }
    }
}

/// All stops of a run.
pub(super) struct Stops {
    /// Kinks until the end, and the end, ascending.
    listed: Vec<StopTime>,
    /// All kinks, ascending.
    kinks: Vec<f64>,
    /// A step, beside which rounding errors of a time near zero are small.
    step: f64,
    /// The k-th interval ends at k `multiple.0 / multiple.1`.
    multiple: (f64, f64),
}

impl Stops {
    pub(super) fn new(system: &mut dyn System, options: &DynamicOptions) -> Self {
        let to = options.to;
        let step = options.step;
        let mut kinks = events(system).kinks();
        kinks.sort_by(f64::total_cmp);
        let mut listed: Vec<StopTime> = Vec::new();
        for t in kinks.iter().copied().filter(|&t| t <= to + slack(to, step)) {
            match listed.last_mut() {
                // `next` leaves out what is within the slack of a time.
                Some(last) if t - last.right <= 2.0 * slack(t, step) => last.right = t,
                _ => listed.push(StopTime {
                    kink: true,
                    ..StopTime::end(t)
                }),
            }
        }
        match listed.last_mut() {
            Some(last) if to - last.left <= slack(to, step) => last.left = to,
            _ => listed.push(StopTime::end(to)),
        }
        let interval = options.interval.unwrap_or(f64::INFINITY);
        let whole = (to / interval).round();
        // A fraction of the end is exact: 3 / 10 for 3 times 0.1.
        let multiple = match (whole * interval - to).abs() <= slack(to, step) {
            true => (to, whole),
            false => (interval, 1.0),
        };
        Self {
            listed,
            kinks,
            step,
            multiple,
        }
    }

    /// The next stop after a time.
    pub(super) fn next(&self, from: f64, options: &DynamicOptions) -> StopTime {
        let slack = slack(from, self.step);
        let k = self.listed.partition_point(|s| s.left <= from + slack);
        let stop = self.listed.get(k).copied();
        let stop = stop.unwrap_or(StopTime::end(options.to));
        let Some(passed) = options.intervals(from) else {
            return stop;
        };
        let (numerator, denominator) = self.multiple;
        let end = (passed + 1.0) * numerator / denominator;
        if end < stop.left - slack {
            StopTime::end(end)
        } else {
            stop
        }
    }

    /// The next kink after a time, also beyond the end.
    pub(super) fn next_kink(&self, t: f64) -> Option<f64> {
        let k = self.kinks.partition_point(|&kink| kink <= t);
        self.kinks.get(k).copied()
    }

    /// Whether there is a kink at the beginning of a run.
    pub(super) fn is_kink(&self, t: f64) -> bool {
        let near = |kink: &f64| (kink - t).abs() <= slack(t, self.step);
        self.kinks.iter().any(near)
    }

    /// The kink behind the end of a step.
    pub(super) fn kink(&self, t: f64) -> Option<StopTime> {
        let k = self.listed.partition_point(|s| s.left <= t);
        let stop = self
            .listed
            .get(k)
            .filter(|s| s.kink && s.left.next_down() == t);
        stop.copied()
    }
}

/// Times closer than this to a time are meant to be equal to it.
pub(super) fn slack(t: f64, step: f64) -> f64 {
    1e-13 * t.abs().max(step)
}

/// Number of equal steps of at most this size in a span of time; a tiny remainder is ignored.
pub(super) fn equal_steps(span: f64, step: f64) -> f64 {
    (span / step - 1e-6).ceil().max(1.0)
}

/// The end of the first of some equal steps between two times.
///
/// Steps are counted from zero, so that rounding errors of their ends do not accumulate.
pub(super) fn first_end([from, to]: [f64; 2], count: f64) -> f64 {
    let h = (to - from) / count;
    let before = (from / h).round();
    if before >= 0.0 && (from - before * h).abs() <= 1e-6 * h {
        to * (before + 1.0) / (before + count)
    } else {
        from + h
    }
}
