//! Steps that end where a system changes its maps.

use super::run::Run;
use super::step::rebase;
use super::{DynamicsError, Progress, State};
use crate::failure::Failure;
use crate::linear_solver::LinearSolver;
use pullback_manifold::system::{Point, System};

/// A change is met when it is overdue by less than this part of a step.
const MET: f64 = 1e-12;
/// A step that would end this part of its size before a change goes on to it.
const NEAR: f64 = 1e-2;
/// A change in this part of a step behind its beginning is made at the beginning.
const SHORT: f64 = 1e-8;
/// Steps shorter than `NEAR` in a row at most, so that what swings to and fro over a change faster than
/// steps can follow costs no more than this.
const MANY: usize = 1000;
/// Attempts at most: Newton's method for the time of a change.
const ATTEMPTS: usize = 8;

/// Maps that were handed over on the way.
#[derive(Default)]
pub(super) struct SegmentChanges {
    /// By what time changes are due at the end of the step: rounding errors, and those of `MET`.
    since: f64,
    /// The time at which changes were made where a step begins: once is enough.
    begun: Option<f64>,
}

fn point(state: &State) -> Point<'_> {
    let State { t, q, v, a, .. } = state;
    Point { t: *t, q, v, a }
}

impl Run<'_> {
    /// Makes the step that was just made from `progress` again where a change lies in it
    /// ([`System::overshoot`]), until it ends with the change, not later than `last`; the time at which
    /// it ends now. `None` where the change was due at the beginning, and is made at the next attempt.
    pub(super) fn end_at_segment_change<Y: System + ?Sized>(
        &mut self,
        system: &mut Y,
        solver: &mut dyn LinearSolver,
        progress: &mut Progress,
        [to, last]: [f64; 2],
    ) -> Result<Option<f64>, Failure> {
        let from = progress.state.t;
        let h = to - from;
        let ulp = f64::EPSILON * from.abs().max(to.abs());
        let met = (MET * h).max(4.0 * ulp);
        let part = if progress.short < MANY { SHORT } else { NEAR };
        let short = (part * h).max(4.0 * met);
        self.segment_changes.since = -met;
        let (mut end, mut near) = (to, NEAR * h);
        for _ in 0..ATTEMPTS {
            let late = system.overshoot(point(&progress.state), point(&self.stepper.next));
            let Some(late) = late.filter(|late| *late > -near && late.abs() > met) else {
                break;
            };
            let aim = end - late + 0.5 * met;
            if aim <= from + short {
                if self.segment_changes.begun == Some(from) {
                    break;
                }
                self.segment_changes.begun = Some(from);
                let begin = end - from - short;
                system.change_segments(point(&progress.state), point(&self.stepper.next), begin);
                return Ok(None);
            }
            if aim > last {
                break;
            }
            (end, near) = (aim, h);
            rebase(progress, end - from);
            let scheme = &self.options.scheme;
            self.stepper
                .step(system, solver, scheme, &progress.state, end)?;
        }
        Ok(Some(end))
    }

    /// Counts short steps, and hands over what is due at the end of the step that was just accepted.
    pub(super) fn finish_step<Y: System + ?Sized>(
        &mut self,
        system: &mut Y,
        progress: &mut Progress,
        h: f64,
    ) {
        let is_short = h < NEAR * progress.next_step;
        progress.short = if is_short { progress.short + 1 } else { 0 };
        // The buffers of the step hold the state before it.
        let (from, to) = (point(&self.stepper.next), point(&progress.state));
        system.change_segments(from, to, self.segment_changes.since);
    }

    /// Whether the last change of charts has handed a map over; what it must keep is then known.
    pub(super) fn segments_changed<Y: System + ?Sized>(
        &mut self,
        system: &mut Y,
        t: f64,
    ) -> Result<bool, DynamicsError> {
        let known = system.kept_momentum(None, &mut self.momentum);
        known.map_err(|source| DynamicsError::System { t, source })
    }

    /// Makes the changes that are due where a step begins.
    pub(super) fn change_segments_at_start<Y: System + ?Sized>(
        &mut self,
        system: &mut Y,
        solver: &mut dyn LinearSolver,
        progress: &mut Progress,
    ) -> Result<(), DynamicsError> {
        let State {
            t,
            q,
            v,
            a,
            algorithmic,
        } = &mut progress.state;
        let t = *t;
        let changes = system.change_charts(t, q, v, &mut [a, algorithmic]);
        progress.summary.chart_changes += changes.charts;
        if !self.segments_changed(system, t)? {
            return Ok(());
        }
        if progress.summary.steps == 0 {
            // The velocities of the start are meant as they are.
            progress.state.a.clear();
            self.accelerate(system, solver, progress)?;
            self.open_balance(system, progress)?;
            return self.set_target(system, progress);
        }
        self.jump(system, solver, progress, t, false)
    }
}
