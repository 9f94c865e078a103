//! A run in time: steps that end at kinks and are halved after a failure.

#![allow(non_snake_case)]

use super::events::{Occurrences, UserEvent};
use super::frequency::check_step;
use super::initial::accelerate;
use super::options::check;
use super::projection::{InvariantProjection, energies};
use super::segment_changes::SegmentChanges;
use super::step::{Stepper, rebase};
use super::stops::{Stop, Stops, equal_steps, first_end};
use super::{DynamicOptions, DynamicsError, EnergyBalance, Progress, State, StepReport, Summary};
use crate::abilities::{self, change_charts, start, symmetries};
use crate::failure::{Cost, FailedStep, Failure, FailureContext, StepParameter};
use crate::linear_solver::{LinearSolver, Symmetry};
use pullback_manifold::system::{Energies, Point, System};

/// Number of steps ahead for which symmetries are found if there is no kink.
const FAR: f64 = 1e3;

/// The engine of a run: all that a step needs beside the system, the solver and the progress.
pub(super) struct Run {
    pub(super) stepper: Stepper,
    /// Times at which a step must end.
    stops: Stops,
    /// A momentum that is conserved at a jump.
    pub(super) momentum: Vec<f64>,
    /// Missing momentum after the jump.
    pub(super) missing: Vec<f64>,
    /// Projection onto the invariants, if the scheme has one.
    pub(super) projection: Option<InvariantProjection>,
    pub(super) segment_changes: SegmentChanges,
    pub(super) occurrences: Occurrences,
    pub(super) options: DynamicOptions,
}

/// An accepted step.
pub(super) struct Accepted {
    pub step_size: f64,
    pub iterations: usize,
    pub chart_changes: usize,
}

impl Run {
    /// The engine at the state of `progress`, ready for its next step.
    pub(super) fn new(
        system: &mut dyn System,
        solver: &mut dyn LinearSolver,
        progress: &mut Progress,
        options: &DynamicOptions,
    ) -> Result<Self, DynamicsError> {
        check(options, progress, system)?;
        // Gyroscopic and centrifugal tangents are not symmetric, even if the stiffness is.
        solver
            .analyse(system.pattern(), Symmetry::General)
            .map_err(|source| DynamicsError::Analysis { source })?;
        let n = system.pattern().dim();
        let mut run = Self {
            stepper: Stepper::new(system, options)?,
            momentum: vec![0.0; n],
            missing: vec![0.0; n],
            stops: Stops::new(system, progress.state.t, options),
            segment_changes: SegmentChanges::default(),
            occurrences: Occurrences::default(),
            projection: (options.scheme.keeps_energy()).then(|| InvariantProjection::new(n)),
            options: *options,
        };
        run.begin(system, solver, progress)?;
        Ok(run)
    }

    /// The next accepted step; `None` at the end of the run.
    pub(super) fn next<Y: System>(
        &mut self,
        system: &mut Y,
        events: &mut [UserEvent<Y>],
        solver: &mut dyn LinearSolver,
        progress: &mut Progress,
    ) -> Result<Option<Accepted>, DynamicsError> {
        while progress.state.t < self.options.to && !self.occurrences.stopped {
            self.take_inputs(system, solver, progress)?;
            if progress.events.len() < events.len() {
                self.watch(system, events, progress)?;
            }
            let Some(step_size) = self.attempt(system, events, solver, progress)? else {
                continue;
            };
            let chart_changes = self.accept(system, solver, progress, step_size)?;
            self.apply_events(system, events, solver, progress)?;
            let iterations = self.stepper.iterations();
            progress.summary.iterations += iterations;
            progress.summary.finished = progress.state.t >= self.options.to;
            return Ok(Some(Accepted {
                step_size,
                iterations,
                chart_changes,
            }));
        }
        progress.summary.finished = progress.state.t >= self.options.to;
        Ok(None)
    }

    /// The report of a step on a progress.
    pub(super) fn report<'a>(&'a self, progress: &'a Progress, step: &Accepted) -> StepReport<'a> {
        StepReport {
            progress,
            step_size: step.step_size,
            iterations: step.iterations,
            residuals: &self.stepper.history,
            chart_changes: step.chart_changes,
            events: &self.occurrences.events,
        }
    }

    /// Charts, accelerations and energies before the first step.
    fn begin(
        &mut self,
        system: &mut dyn System,
        solver: &mut dyn LinearSolver,
        progress: &mut Progress,
    ) -> Result<(), DynamicsError> {
        let fresh = progress.state.a.is_empty();
        // A continued run may have another step.
        let DynamicOptions { step, min_step, .. } = self.options;
        if self.options.adaptivity.is_none() {
            progress.next_step = progress.next_step.min(step);
        }
        if progress.next_step < min_step {
            progress.next_step = step;
        }
        let State {
            t,
            q,
            v,
            a,
            algorithmic,
        } = &mut progress.state;
        // A system without this state chooses its charts; an accepted state keeps its charts.
        start(system, *t, q);
        let mut none: [&mut [f64]; 0] = [];
        let mut both: [&mut [f64]; 2] = [a, algorithmic];
        let vectors: &mut [&mut [f64]] = if fresh { &mut none } else { &mut both };
        let changed = change_charts(system, *t, q, v, vectors).charts;
        if fresh {
            progress.summary.chart_changes += changed;
            progress.inputs = abilities::events(system).inputs();
            progress.state.a = vec![0.0; progress.state.q.len()];
        }
        let t = progress.state.t;
        if std::mem::take(&mut progress.at_kink) && self.stops.is_kink(t) {
            self.pass(system, solver, progress, Stop::end(t))?;
        } else if fresh {
            progress.state.a.clear();
            self.accelerate(system, solver, progress)?;
        }
        if fresh {
            self.open_balance(system, progress)?;
        }
        let State { t, q, v, .. } = &progress.state;
        match &progress.invariants {
            // A system that is new to a run finds its symmetries again.
            Some(kept) if self.projection.is_some() && !kept.motions.is_empty() => {
                let span = [*t, self.next_kink(*t)];
                symmetries(system, span, q, v);
            }
            Some(_) if self.projection.is_some() => {}
            _ => self.set_target(system, progress)?,
        }
        let Stepper { r, S, .. } = &mut self.stepper;
        let scheme = &self.options.scheme;
        let step = match self.options.adaptivity {
            // An embedded method limits the steps by itself.
            Some(_) if scheme.embedded().is_some() => 0.0,
            Some(adaptivity) => adaptivity.max_step,
            None => step,
        };
        progress.summary.stable_step =
            check_step(system, solver, &progress.state, scheme, step, [r, S])?;
        Ok(())
    }

    /// Starts the energy balance at the present state.
    pub(super) fn open_balance(
        &self,
        system: &mut dyn System,
        progress: &mut Progress,
    ) -> Result<(), DynamicsError> {
        let now = self.energies(system, &progress.state, progress.state.t)?;
        progress.summary.energy = now.map(|now| EnergyBalance {
            start: now.kinetic + now.stored,
            now,
            ..EnergyBalance::default()
        });
        Ok(())
    }

    /// The next kink, or a time some steps away.
    fn next_kink(&self, t: f64) -> f64 {
        let far = t + FAR * self.options.step;
        self.stops.next_kink(t).map_or(far, |kink| kink.min(far))
    }

    /// Sets the invariants of this state as the target of the projection.
    pub(super) fn set_target(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
    ) -> Result<(), DynamicsError> {
        let until = self.next_kink(progress.state.t);
        let Stepper { r, S, .. } = &mut self.stepper;
        let scheme = &self.options.scheme;
        progress.invariants = match &mut self.projection {
            Some(projection) => {
                Some(projection.set_target(system, scheme, &progress.state, until, [r, S])?)
            }
            None => None,
        };
        Ok(())
    }

    /// Updates the accelerations of the state; see [`accelerate`].
    pub(super) fn accelerate(
        &mut self,
        system: &mut dyn System,
        solver: &mut dyn LinearSolver,
        progress: &mut Progress,
    ) -> Result<(), DynamicsError> {
        let Stepper { r, S, .. } = &mut self.stepper;
        progress.summary.evaluations += 1;
        progress.summary.factorisations += 1;
        let h = self.options.step.min(progress.next_step);
        accelerate(system, solver, &mut progress.state, h, [r, S])
    }

    pub(super) fn energies(
        &self,
        system: &mut dyn System,
        state: &State,
        t: f64,
    ) -> Result<Option<Energies>, DynamicsError> {
        if !self.options.energies && self.projection.is_none() {
            return Ok(None);
        }
        let at = Point {
            t,
            q: &state.q,
            v: &state.v,
            a: &state.a,
        };
        abilities::energies(system, at).map_err(|source| DynamicsError::System { t, source })
    }

    /// One attempt at a step; its size if it may be accepted, `None` if a smaller one is needed.
    fn attempt<Y: System>(
        &mut self,
        system: &mut Y,
        events: &mut [UserEvent<Y>],
        solver: &mut dyn LinearSolver,
        progress: &mut Progress,
    ) -> Result<Option<f64>, DynamicsError> {
        let from = progress.state.t;
        let stop = self.stops.next(from, &self.options);
        let count = equal_steps(stop.left - from, progress.next_step);
        let h = (stop.left - from) / count;
        // A step ends before a kink: functions of time are evaluated on its left.
        let to = match (count > 1.0, stop.kink) {
            (true, _) => first_end([from, stop.left], count),
            (false, true) => stop.left.next_down(),
            (false, false) => stop.left,
        };
        rebase(progress, h);
        let before = (self.stepper.evaluations, self.stepper.factorisations);
        let scheme = &self.options.scheme;
        let outcome = self
            .stepper
            .step(system, solver, scheme, &progress.state, to);
        let last = if count > 1.0 {
            stop.left.next_down()
        } else {
            to
        };
        let outcome =
            outcome.and_then(|()| self.locate(system, events, solver, progress, [to, last]));
        progress.summary.evaluations += self.stepper.evaluations - before.0;
        progress.summary.factorisations += self.stepper.factorisations - before.1;
        let end = match outcome {
            Ok(Some(end)) => end,
            Ok(None) => {
                self.change_segments_at_start(system, solver, progress)?;
                return Ok(None);
            }
            Err(failure) => {
                progress.summary.failed += 1;
                return self.halve(system, progress, failure, [from, to]);
            }
        };
        let h = if end == to { h } else { end - from };
        if count <= 1.0 && end == to {
            self.stepper.next.t = stop.left;
        }
        let Some(adaptivity) = self.options.adaptivity else {
            return Ok(Some(h));
        };
        let (error, power) = self.local_error(system, &progress.state, h);
        let ratio = adaptivity.tolerance / error;
        let factor = (0.9 * ratio.powf(1.0 / power)).clamp(0.3, 2.0);
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
            return self.halve(system, progress, Failure::Inaccurate, [from, to]);
        }
        progress.next_step = wanted;
        Ok(None)
    }

    /// Halves the step after a failure, or ends the run.
    fn halve(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
        failure: Failure,
        span: [f64; 2],
    ) -> Result<Option<f64>, DynamicsError> {
        progress.easy = 0;
        progress.next_step = 0.5 * (span[1] - span[0]);
        if progress.next_step >= self.options.min_step && progress.next_step > 0.0 {
            return Ok(None);
        }
        let Stepper { r, S, history, .. } = &self.stepper;
        let context = FailureContext {
            failure,
            r,
            S,
            history,
        };
        let Summary {
            steps,
            failed,
            inaccurate,
            evaluations,
            factorisations,
            ..
        } = progress.summary;
        let rejected = failed + inaccurate;
        let cost = Cost {
            evaluations,
            factorisations,
        };
        let time = StepParameter::Time;
        let step = FailedStep::new(system, context, time, span, steps, rejected, cost);
        Err(DynamicsError::Step(Box::new(step)))
    }

    /// Accepts the new state and updates charts, and accelerations after a kink.
    fn accept(
        &mut self,
        system: &mut dyn System,
        solver: &mut dyn LinearSolver,
        progress: &mut Progress,
        h: f64,
    ) -> Result<usize, DynamicsError> {
        let left = self.stepper.next.t;
        let kink = self.stops.kink(left);
        let t_left = if kink.is_some() {
            left.next_down()
        } else {
            left
        };
        let damped = (progress.summary.energy).is_some_and(|e| e.now.dissipated != 0.0);
        let dissipated = match damped {
            true => self.mean_dissipation(system, &progress.state, t_left),
            false => None,
        };
        // The evaluation leaves the system at the end of the step.
        let mut now = self.energies(system, &self.stepper.next, t_left)?;
        std::mem::swap(&mut progress.state, &mut self.stepper.next);
        progress.last_step = h;
        progress.summary.steps += 1;
        self.finish_step(system, progress, h);
        let State {
            t,
            q,
            v,
            a,
            algorithmic,
        } = &mut progress.state;
        let changes = change_charts(system, *t, q, v, &mut [a, algorithmic]);
        progress.summary.chart_changes += changes.charts;
        let segments_changed = self.segments_changed(system, left)?;
        if let (true, Some(kept), Some(now)) = (segments_changed, &mut progress.invariants, &now) {
            // The jump restores what is missing.
            kept.add_step(now, h);
        } else if let (Some(projection), Some(kept)) =
            (&mut self.projection, &mut progress.invariants)
        {
            let (scheme, state) = (&self.options.scheme, &mut progress.state);
            if let (true, Some(now)) = (changes.residual, &now) {
                // The discretisation itself depends on charts.
                kept.energy += energies(system, scheme, state, t_left)?.total() - now.total();
            }
            let Stepper { r, S, .. } = &mut self.stepper;
            let restored = projection.restore(system, scheme, state, kept, (t_left, h), [r, S])?;
            now = now.map(|_| restored);
            progress.summary.evaluations += projection.take_evaluations();
        }
        if let (Some(now), Some(balance)) = (now, &mut progress.summary.energy) {
            balance.add_step(&now, h, dissipated, &system.scales());
            balance.check_growth(left)?;
        }
        if segments_changed {
            self.jump(system, solver, progress, left, false)?;
        }
        match kink {
            // The end of a run does not pass a kink.
            Some(_) if left >= self.options.to => progress.at_kink = true,
            Some(stop) => self.pass(system, solver, progress, stop)?,
            None => {}
        }
        if self.options.adaptivity.is_none() {
            progress.easy += 1;
            let nominal = self.options.step;
            let stop = self.stops.next(progress.state.t, &self.options);
            let rest = equal_steps(stop.left - progress.state.t, progress.next_step);
            // With an odd number of steps left, doubled steps would miss the times of the steps
            // before they were halved.
            let pairs = rest % 2.0 == 0.0;
            if progress.easy >= self.options.easy && progress.next_step < nominal && pairs {
                progress.next_step = nominal.min(2.0 * progress.next_step);
                progress.easy = 0;
            }
        }
        Ok(changes.charts)
    }

    /// Power of dampers midway between a state and the next one, with the velocity (q₁ − q₀) / h.
    ///
    /// The powers at both ends may be those of dampers that relax within a small part of the step. This
    /// one is the dissipation of the trapezoidal rule in a linear system, for any step. `None` if the
    /// system cannot be evaluated there: a converged step must not fail by its energy balance.
    fn mean_dissipation(
        &mut self,
        system: &mut dyn System,
        state: &State,
        end: f64,
    ) -> Option<f64> {
        let Stepper {
            next,
            inverse_scale,
            ..
        } = &self.stepper;
        let (q, v, h) = (&mut self.momentum, &mut self.missing, next.t - state.t);
        for i in 0..q.len() {
            q[i] = 0.5 * (state.q[i] + next.q[i]);
            // Multipliers have no rates.
            v[i] = match inverse_scale[i] {
                0.0 => 0.0,
                _ => (next.q[i] - state.q[i]) / h,
            };
        }
        let t = 0.5 * (state.t + end);
        let a = &next.a;
        let mean = abilities::energies(system, Point { t, q, v, a });
        Some(mean.ok()??.dissipated)
    }

    /// Largest local error of the coordinates over their scales, and the power of h with which it falls:
    /// the estimate of Zienkiewicz & Xie 1991 or that of an embedded method, where an error of a
    /// velocity counts by its displacement in a step.
    fn local_error(&self, system: &dyn System, state: &State, h: f64) -> (f64, f64) {
        let scheme = &self.options.scheme;
        let Some((row, power)) = scheme.error_estimate() else {
            return (f64::MIN_POSITIVE, 1.0);
        };
        let scales = system.scales().coordinate;
        // The last stage is in the new state.
        let Stepper { stages, next, .. } = &self.stepper;
        let inner = stages[..stages.len() - 1].iter().map(|stage| &stage.state);
        let all = std::iter::once(state).chain(inner).chain([next]);
        let mut largest = f64::MIN_POSITIVE;
        for i in 0..state.q.len() {
            let info = system.coordinate_info(i);
            if info.is_multiplier {
                continue;
            }
            let mut errors = [0.0_f64; 2];
            for (y, (q, v)) in all.clone().zip(row.q.iter().zip(&row.v)) {
                errors[0] += q * y.algorithmic[i];
                errors[1] += v * y.algorithmic[i];
            }
            let error = errors[0].abs().max(errors[1].abs());
            largest = largest.max(h * h * error / scales[info.quantity.index()]);
        }
        (largest, power as f64)
    }
}
