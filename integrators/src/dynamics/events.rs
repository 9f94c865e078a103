//! Events of a run: a value that crosses zero, and its effect.

use super::options::check;
use super::run::MotionRun;
use super::segment_changes::{MANY, SHORT};
use super::{DynamicsError, Progress, State};
use crate::abilities;
use crate::failure::{Cause, significant};
use crate::vectors::add;
use pullback_manifold::system::{Evaluation, System, SystemError};
use std::ops::ControlFlow;

/// An event; see [`Simulation::add_event`](super::Simulation::add_event).
pub(super) struct UserEvent<Y> {
    pub value: Box<Value<Y>>,
    pub apply: Box<Effect<Y>>,
}

type Value<Y> = dyn FnMut(&Y, &State) -> f64 + Send;
type Effect<Y> = dyn FnMut(&mut Y, &mut State) -> ControlFlow<()> + Send;

/// State of the search for events.
#[derive(Default)]
pub(super) struct Occurrences {
    /// Values at the end of the step.
    values: Vec<f64>,
    /// Events with at least this value occur there, in parts of that at the beginning.
    pub least: Option<f64>,
    /// Events at the end of the last step.
    pub events: Vec<usize>,
    /// Whether one of them stopped the run.
    pub stopped: bool,
}

impl MotionRun {
    /// The largest value of the events at the end of the step, in parts of that at the beginning;
    /// −∞ if no event is ahead.
    pub(super) fn event_value<Y: System>(
        &mut self,
        system: &mut Y,
        events: &mut [UserEvent<Y>],
        before: &[f64],
    ) -> Result<f64, Cause> {
        let values = &mut self.occurrences.values;
        evaluate(system, events, &self.stepper.next, values).map_err(Cause::System)?;
        Ok(ratios(before, values).fold(f64::NEG_INFINITY, |m, (_, ratio)| m.max(ratio)))
    }

    /// Applies the events at the end of the accepted step. Accelerations that an effect clears are computed anew, from those before.
    pub(super) fn apply_events<Y: System>(
        &mut self,
        system: &mut Y,
        events: &mut [UserEvent<Y>],
        progress: &mut Progress,
    ) -> Result<(), DynamicsError> {
        let now = &mut self.occurrences;
        now.events.clear();
        if let Some(least) = now.least {
            let occurring = ratios(&progress.events, &now.values).filter(|(_, x)| *x >= least);
            now.events.extend(occurring.map(|(k, _)| k));
        }
        if now.events.is_empty() {
            progress.events.clone_from(&now.values);
            return Ok(());
        }
        let (t, mut after, mut stopped) = (progress.state.t, progress.clone(), false);
        after.events.clone_from(&now.values);
        let refused = |what, expected, found| {
            let source = SystemError::Request {
                what,
                expected,
                found,
            };
            Err(DynamicsError::System { t, source })
        };
        let mut effects = now.events.iter().try_for_each(|&k| {
            after.events[k] = 0.0;
            stopped |= (events[k].apply)(system, &mut after.state).is_break();
            if after.state.a.is_empty() {
                after.state.a.clone_from(&progress.state.a);
            }
            if after.state.t != t {
                let found = format!("{:?}", after.state.t);
                return refused("time after an event", format!("{t:?}, as before"), found);
            }
            check(&self.options, &after.state, system)?;
            // The next effect finds the system at the state that this one leaves.
            configure(system, &after.state).map_err(DynamicsError::at(t))
        });
        if progress.short >= MANY && !stopped {
            let expected = format!(
                "fewer than {MANY} short steps in a row (let an effect hold what chatters or comes to rest, or end the run)"
            );
            let found = format!("events {:?} once more", now.events);
            effects = effects.and(refused("events", expected, found));
        }
        let outcome = effects
            .and_then(|()| self.refresh(system, &mut after))
            .and_then(|()| self.watch(system, events, &mut after));
        if outcome.is_err() {
            // Nothing of the effect is left.
            abilities::events(system)
                .inputs()
                .copy_from_slice(&progress.inputs);
            return outcome;
        }
        self.occurrences.stopped |= stopped;
        *progress = after;
        Ok(())
    }

    /// Finds the values of events that are new, have occurred, or read inputs, just behind the present state: an
    /// event whose value is below zero there may occur, and one that was below zero before.
    pub(super) fn watch<Y: System>(
        &mut self,
        system: &mut Y,
        events: &mut [UserEvent<Y>],
        progress: &mut Progress,
    ) -> Result<(), DynamicsError> {
        let mut state = progress.state.clone();
        // Their times are known to rounding errors, and to those of the step.
        let h = SHORT * self.options.step.max(progress.next_step);
        let (t, h) = (state.t, h.max(16.0 * f64::EPSILON * state.t.abs()));
        state.t += h;
        add(&mut state.q, h, &state.v);
        add(&mut state.v, h, &state.a);
        let values = &mut self.occurrences.values;
        evaluate(system, events, &state, values)
            .and_then(|()| configure(system, &progress.state))
            .map_err(DynamicsError::at(t))?;
        progress.events.resize(events.len(), 0.0);
        for (old, new) in progress.events.iter_mut().zip(values) {
            if *old >= 0.0 || *new < 0.0 {
                *old = *new;
            }
        }
        Ok(())
    }
}

/// Events whose value was below zero, with their values in parts of that.
fn ratios<'a>(before: &'a [f64], values: &'a [f64]) -> impl Iterator<Item = (usize, f64)> + 'a {
    let pairs = before.iter().zip(values).enumerate();
    let ahead = pairs.filter(|(_, (before, _))| **before < 0.0);
    ahead.map(|(k, (before, value))| (k, value / -before))
}

/// Evaluates the system at a state: its configuration is then that.
pub(super) fn configure(system: &mut dyn System, state: &State) -> Result<(), SystemError> {
    let mut r = vec![0.0; state.q.len()];
    system.evaluate(state.point(), Evaluation::residual(&mut r))
}

/// Values of events at a state, with the system there.
fn evaluate<Y: System>(
    system: &mut Y,
    events: &mut [UserEvent<Y>],
    state: &State,
    values: &mut Vec<f64>,
) -> Result<(), SystemError> {
    values.clear();
    if events.is_empty() {
        return Ok(());
    }
    configure(system, state)?;
    for (k, event) in events.iter_mut().enumerate() {
        let value = (event.value)(system, state);
        if !value.is_finite() {
            return Err(SystemError::Request {
                what: "value of an event",
                expected: "a finite number".to_owned(),
                found: format!("{value} of event {k} at time {}", significant(state.t)),
            });
        }
        values.push(value);
    }
    Ok(())
}

/// Regula falsi with the Illinois modification, for the time at which a value crosses zero from
/// below: two times and their values, the second one the latest.
pub(super) struct Crossing([(f64, f64); 2]);

impl Crossing {
    /// A crossing after a time at which the value is −1.
    pub(super) fn new(from: f64) -> Self {
        Self([(from, -2.0), (from, -1.0)])
    }

    /// Amount by which a time with this value is later than the crossing, negative before it; −∞ if
    /// the value moves away from zero.
    pub(super) fn overshoot(&mut self, t: f64, value: f64) -> f64 {
        let [other, latest] = &mut self.0;
        if value * latest.1 < 0.0 {
            *other = *latest;
        } else {
            other.1 *= 0.5;
        }
        *latest = (t, value);
        let width = t - other.0;
        let by = value * width / (value - other.1);
        if value <= other.1 && other.1 < 0.0 {
            f64::NEG_INFINITY
        } else if value < -0.5 && by > 1e-3 * width {
            // The value at the beginning may itself be close to zero: bisection leaves it behind.
            0.5 * width
        } else {
            by
        }
    }
}
