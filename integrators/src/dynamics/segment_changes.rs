//! Steps that end at an event: a change of segment of the system's maps, or an event of the user.

use super::events::{Crossing, UserEvent};
use super::run::MotionRun;
use super::step::rebase;
use super::{DynamicsError, Progress};
use crate::abilities::events;
use crate::failure::Cause;
use pullback_manifold::system::System;

/// Tolerance of the time of an event, as a part of a step.
const MET: f64 = 1e-12;
/// A step that ends by this part of its size before an event is extended to it.
const NEAR: f64 = 1e-2;
/// A change within this part of a step after its beginning is made at the beginning, and an event of
/// the user at the end of a step of this size.
pub(super) const SHORT: f64 = 1e-8;
/// Largest number of steps in a row shorter than `NEAR`, which limits the cost of oscillations
/// about a change that are faster than the steps.
pub(super) const MANY: usize = 1000;
/// Largest number of attempts by Newton's method, for the time of a change of segment.
const NEWTON: usize = 8;
/// Largest number of attempts by regula falsi, for the time of an event of the user.
const REGULA_FALSI: usize = 100;

/// State of the search for changes of segment.
#[derive(Default)]
pub(super) struct SegmentSearch {
    /// Least overshoot at which changes are made at the end of the step: rounding errors, and `MET`.
    since: f64,
    /// The time at which changes were made at the beginning of a step, to make them once.
    begun: Option<f64>,
}

impl MotionRun {
    /// Repeats the step from `progress` until it ends at the first event within it, a change of
    /// segment ([`Events::value`](pullback_manifold::system::Events::value)) or one of `watched`,
    /// not later than `last`; returns the end of the step. `None` if a change of segment is at the
    /// beginning, where the next attempt makes it.
    pub(super) fn locate<Y: System>(
        &mut self,
        system: &mut Y,
        watched: &mut [UserEvent<Y>],
        progress: &mut Progress,
        [to, last]: [f64; 2],
    ) -> Result<Option<f64>, Cause> {
        let from = progress.state.t;
        let h = to - from;
        let ulp = f64::EPSILON * from.abs().max(to.abs());
        let met = (MET * h).max(4.0 * ulp);
        let part = if progress.short < MANY { SHORT } else { NEAR };
        let short = (part * h).max(4.0 * met);
        self.segment_changes.since = -met;
        let (mut end, mut near) = (to, NEAR * h);
        let mut crossing = Crossing::new(from);
        for attempt in 0..=REGULA_FALSI {
            let value = self.event_value(system, watched, &progress.events)?;
            let event = crossing.overshoot(end, value);
            self.occurrences.least = (event >= -met).then(|| value.min(0.0) - MET);
            let (start, next) = (progress.state.point(), self.stepper.next.point());
            let target = |by: f64| end - by + 0.5 * met;
            let mut segment = events(system).value(start, next);
            if target(segment) <= from + short && self.segment_changes.begun == Some(from) {
                segment = f64::NEG_INFINITY;
            }
            let by = segment.max(event);
            let most = [NEWTON, REGULA_FALSI][usize::from(event > segment)];
            if !(by > -near && by.abs() > met) || attempt == most {
                break;
            }
            if by == segment && target(by) <= from + short {
                self.segment_changes.begun = Some(from);
                let begin = end - from - short;
                events(system).apply(start, next, begin);
                return Ok(None);
            }
            let target = target(by).max(from + (SHORT * h).max(4.0 * met));
            if target > last || target == end {
                break;
            }
            // An event of the user that may lie ahead of the step has one attempt.
            let ahead = by > segment && by < 0.0 && near < h;
            (end, near) = (target, if ahead { 0.0 } else { h });
            rebase(progress, end - from);
            let scheme = &self.options.scheme;
            self.stepper.step(system, scheme, &progress.state, end)?;
        }
        Ok(Some(end))
    }

    /// Counts short steps, and makes the changes at the end of the accepted step.
    pub(super) fn finish_step(&mut self, system: &mut dyn System, progress: &mut Progress, h: f64) {
        let is_short = h < NEAR * progress.next_step;
        progress.short = if is_short { progress.short + 1 } else { 0 };
        // The buffers of the step hold the previous state.
        let (from, to) = (self.stepper.next.point(), progress.state.point());
        events(system).apply(from, to, self.segment_changes.since);
    }

    /// Whether the last change of charts changed a segment; the momentum to conserve is then known.
    pub(super) fn segments_changed(
        &mut self,
        system: &mut dyn System,
        t: f64,
    ) -> Result<bool, DynamicsError> {
        let known = events(system).kept_momentum(None, &mut self.momentum);
        known.map_err(DynamicsError::at(t))
    }

    /// Makes the changes of segment at the beginning of a step.
    pub(super) fn change_segments_at_start(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
    ) -> Result<(), DynamicsError> {
        let t = progress.state.t;
        let changes = progress.state.change_charts(system);
        progress.summary.chart_changes += changes.charts;
        if !self.segments_changed(system, t)? {
            return Ok(());
        }
        if progress.summary.steps == 0 {
            // Initial velocities are valid after the change.
            progress.state.a.fill(0.0);
            self.accelerate(system, progress, false)?;
            self.open_balance(system, progress)?;
            return self.set_target(system, progress);
        }
        self.jump(system, progress, false)
    }
}
