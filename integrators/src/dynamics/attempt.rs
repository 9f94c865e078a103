//! One attempt at a step: its end, and the size of the next one.

use super::events::UserEvent;
use super::run::MotionRun;
use super::scheme::Stage;
use super::step::{Stepper, rebase};
use super::stops::{equal_steps, first_end};
use super::{DynamicsError, Progress, State};
use crate::failure::Cause;
use pullback_manifold::system::System;

/// The end of an attempted step.
pub(super) struct Goal {
    pub h: f64,
    to: f64,
    /// The latest time to which the step may be extended.
    last: f64,
}

impl MotionRun {
    /// One attempt at a step; its size if it may be accepted, `None` if a smaller one is needed.
    pub(super) fn attempt<Y: System>(
        &mut self,
        system: &mut Y,
        events: &mut [UserEvent<Y>],
        progress: &mut Progress,
    ) -> Result<Option<f64>, DynamicsError> {
        let from = progress.state.t;
        let Goal { h, to, last } = self.goal(progress);
        if to <= from {
            return Err(DynamicsError::Option {
                name: "step",
                value: h,
                wanted: "it must be larger than the rounding error of the time",
            });
        }
        rebase(progress, h);
        let before = (self.stepper.evaluations, self.stepper.factorisations);
        let scheme = &self.options.scheme;
        let outcome = (self.stepper).step(system, scheme, &progress.state, to);
        let outcome = outcome.and_then(|()| self.locate(system, events, progress, [to, last]));
        progress.summary.evaluations += self.stepper.evaluations - before.0;
        progress.summary.factorisations += self.stepper.factorisations - before.1;
        let end = match outcome {
            Ok(Some(end)) => end,
            Ok(None) => {
                self.change_segments_at_start(system, progress)?;
                return Ok(None);
            }
            Err(failure) => {
                progress.summary.failed += 1;
                return self.halve(system, progress, failure, [from, to]);
            }
        };
        let h = if end == to { h } else { end - from };
        self.limit_error(system, progress, h, [from, to])
    }

    /// The end of the next step.
    pub(super) fn goal(&self, progress: &Progress) -> Goal {
        let from = progress.state.t;
        let stop = self.stops.next(from, &self.options);
        let count = equal_steps(stop.left - from, progress.next_step);
        let h = (stop.left - from) / count;
        if count > 1.0 {
            return Goal {
                h,
                to: first_end([from, stop.left], count),
                last: stop.left.next_down(),
            };
        }
        // A step ends before a kink: functions of time are evaluated on its left.
        let to = match stop.kink {
            true => stop.left.next_down(),
            false => stop.left,
        };
        Goal { h, to, last: to }
    }

    /// The size of a converged step if its local error is small enough, `None` if a smaller one is
    /// needed; chooses the size of the next one.
    fn limit_error(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
        h: f64,
        span: [f64; 2],
    ) -> Result<Option<f64>, DynamicsError> {
        // Adaptive steps are those of schemes with an estimate.
        let estimate = |adaptivity| Some((adaptivity, self.options.scheme.error_estimate()?));
        let Some((adaptivity, (row, power))) = self.options.adaptivity.and_then(estimate) else {
            return Ok(Some(h));
        };
        let error = self.local_error(system, &progress.state, &row, h);
        let ratio = adaptivity.tolerance / error;
        let factor = (0.9 * ratio.powf(1.0 / power as f64)).clamp(0.3, 2.0);
        // A step shortened by a stop does not limit the next one.
        let wanted = (h * factor).min(adaptivity.max_step);
        if error <= adaptivity.tolerance {
            let forced = h < 0.99 * progress.next_step && factor >= 1.0;
            progress.next_step = if forced {
                progress.next_step.max(wanted)
            } else {
                wanted
            };
            return Ok(Some(h));
        }
        progress.summary.inaccurate += 1;
        if wanted < self.options.min_step {
            return self.halve(system, progress, Cause::Inaccurate, span);
        }
        progress.next_step = wanted;
        Ok(None)
    }

    /// Halves the step after a failure, or ends the run.
    fn halve(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
        failure: Cause,
        span: [f64; 2],
    ) -> Result<Option<f64>, DynamicsError> {
        progress.easy = 0;
        let half = 0.5 * (span[1] - span[0]);
        if half >= self.options.min_step {
            progress.next_step = half;
            return Ok(None);
        }
        Err((self.stepper).fail(system, failure, span, &progress.summary))
    }

    /// Largest local error of the coordinates over their scales, from the row of its estimate: that of
    /// Zienkiewicz & Xie 1991 or of an embedded method, where an error of a velocity counts by its
    /// displacement in a step.
    fn local_error(&self, system: &dyn System, state: &State, row: &Stage, h: f64) -> f64 {
        // The last stage is in the new state.
        let Stepper { stages, next, .. } = &self.stepper;
        let inner = stages[..stages.len() - 1].iter().map(|stage| &stage.state);
        let all = std::iter::once(state).chain(inner).chain([next]);
        let mut largest = f64::MIN_POSITIVE;
        for i in 0..state.q.len() {
            let info = system.pattern().coordinates()[i];
            if info.is_multiplier {
                continue;
            }
            let mut errors = [0.0_f64; 2];
            for (y, (q, v)) in all.clone().zip(row.q.iter().zip(&row.v)) {
                errors[0] += q * y.a[i];
                errors[1] += v * y.a[i];
            }
            let error = errors[0].abs().max(errors[1].abs());
            largest = largest.max(h * h * error / info.size);
        }
        largest
    }
}
