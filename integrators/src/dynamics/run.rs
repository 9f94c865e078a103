//! A run in time: steps that end at kinks and are halved after a failure.

use super::events::{Occurrences, UserEvent, configure};
use super::frequency::check_step;
use super::options::check;
use super::projection::InvariantProjection;
use super::segment_changes::SegmentSearch;
use super::step::Stepper;
use super::stops::{StopTime, Stops};
use super::{DynamicOptions, DynamicsError, EnergyBalance, Progress, State, StepReport};
use crate::abilities::{self, charts, energetics};
use pullback_manifold::system::{Energies, System};

/// Number of steps ahead for which symmetries are found if there is no kink.
const FAR: f64 = 1e3;

/// The engine of a run: all that a step needs beside the system and the progress.
pub(super) struct MotionRun {
    pub(super) stepper: Stepper,
    /// Times at which a step must end.
    pub(super) stops: Stops,
    /// A momentum that is conserved at a jump.
    pub(super) momentum: Vec<f64>,
    /// Missing momentum after the jump.
    pub(super) missing: Vec<f64>,
    /// Projection onto the invariants, if the scheme has one.
    pub(super) projection: Option<InvariantProjection>,
    pub(super) segment_changes: SegmentSearch,
    pub(super) occurrences: Occurrences,
    pub(super) options: DynamicOptions,
}

impl MotionRun {
    /// The engine at the state of `progress`, ready for its next step.
    pub(super) fn new(
        system: &mut dyn System,
        progress: &mut Progress,
        options: &DynamicOptions,
    ) -> Result<Self, DynamicsError> {
        check(options, &progress.state, system)?;
        let n = system.pattern().dim();
        let mut run = Self {
            stepper: Stepper::new(system, options)?,
            momentum: vec![0.0; n],
            missing: vec![0.0; n],
            stops: Stops::new(system, options),
            segment_changes: SegmentSearch::default(),
            occurrences: Occurrences::default(),
            projection: (options.scheme.keeps_energy())
                .then(|| InvariantProjection::new(n, options.scheme.name)),
            options: *options,
        };
        run.begin(system, progress)?;
        Ok(run)
    }

    /// Changes the size of the steps from the next one on.
    pub(super) fn set_step(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
        step: f64,
    ) -> Result<(), DynamicsError> {
        let before = self.options;
        self.options.step = step;
        self.options.min_step = before.min_step.min(step);
        let checked = check(&self.options, &progress.state, system)
            .and_then(|()| self.find_stable_step(system, progress));
        if checked.is_err() {
            self.options = before;
            return checked;
        }
        self.stops = Stops::new(system, &self.options);
        let longest = self.options.adaptivity.map_or(step, |a| a.max_step);
        progress.next_step = step.min(longest);
        Ok(())
    }

    /// The next accepted step; `None` at the end of the run. After an error the system is at the last
    /// accepted step.
    pub(super) fn next<'a, Y: System>(
        &'a mut self,
        system: &mut Y,
        events: &mut [UserEvent<Y>],
        progress: &'a mut Progress,
    ) -> Result<Option<StepReport<'a>>, DynamicsError> {
        let step = self.advance(system, events, progress);
        if step.is_err() {
            configure(system, &progress.state).ok();
        }
        Ok(step?.map(|(step_size, chart_changes)| StepReport {
            progress,
            step_size,
            iterations: self.stepper.iterations(),
            residuals: &self.stepper.history,
            chart_changes,
            events: &self.occurrences.events,
        }))
    }

    /// The size of the next accepted step, and its number of changes of chart.
    fn advance<Y: System>(
        &mut self,
        system: &mut Y,
        events: &mut [UserEvent<Y>],
        progress: &mut Progress,
    ) -> Result<Option<(f64, usize)>, DynamicsError> {
        while progress.state.t < self.options.to && !self.occurrences.stopped {
            let changed = self.take_inputs(system, progress)?;
            if changed || progress.events.len() < events.len() {
                self.watch(system, events, progress)?;
            }
            let Some(step_size) = self.attempt(system, events, progress)? else {
                continue;
            };
            let chart_changes = self.accept(system, progress, step_size)?;
            self.apply_events(system, events, progress)?;
            progress.summary.iterations += self.stepper.iterations();
            progress.summary.finished = progress.state.t >= self.options.to;
            return Ok(Some((step_size, chart_changes)));
        }
        progress.summary.finished = progress.state.t >= self.options.to;
        Ok(None)
    }

    /// Charts, accelerations and energies before the first step.
    fn begin(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
    ) -> Result<(), DynamicsError> {
        let fresh = progress.state.a.is_empty();
        // A continued run may have another step.
        let DynamicOptions { step, min_step, .. } = self.options;
        if progress.next_step < min_step {
            progress.next_step = step;
        }
        let longest = self.options.adaptivity.map_or(step, |a| a.max_step);
        progress.next_step = progress.next_step.min(longest);
        let (t, state) = (progress.state.t, &mut progress.state);
        // A system without this state chooses its charts; an accepted state keeps its charts.
        charts(system).start(t, &state.q);
        let changes = match fresh {
            true => charts(system).change_charts(t, &mut state.q, &mut state.v, &mut []),
            false => state.change_charts(system),
        };
        if fresh {
            progress.summary.chart_changes += changes.charts;
            progress.inputs = abilities::events(system).inputs().to_vec();
            let state = &mut progress.state;
            for a in [&mut state.a, &mut state.algorithmic, &mut state.filtered] {
                *a = vec![0.0; state.q.len()];
            }
            // What is kept of a run whose state was changed belongs to the one before.
            (progress.events, progress.invariants) = (Vec::new(), None);
            if self.stops.is_kink(t) {
                progress.state.t = t.next_down();
                self.pass(system, progress, StopTime::end(t))?;
            } else {
                self.accelerate(system, progress, false)?;
            }
            self.stepper.check_gaps(system, &progress.state)?;
            self.open_balance(system, progress)?;
        }
        let State { t, q, v, .. } = &progress.state;
        match &progress.invariants {
            Some(kept) if self.projection.is_some() => {
                // A system that is new to a run finds its symmetries again.
                if !kept.momenta.is_empty() {
                    let span = [*t, self.next_kink(*t)];
                    energetics(system).symmetries(span, q, v);
                    // The evaluation leaves the system at the state.
                    self.energies(system, &progress.state)?;
                }
            }
            _ => self.set_target(system, progress)?,
        }
        self.find_stable_step(system, progress)
    }

    /// Finds the stability limit of the step at the present state, and rejects a step beyond it. A step that was
    /// stable where the run began is not checked again.
    fn find_stable_step(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
    ) -> Result<(), DynamicsError> {
        let scheme = &self.options.scheme;
        let step = match self.options.adaptivity {
            // An embedded method limits the steps by itself.
            Some(_) if scheme.embedded().is_some() => 0.0,
            Some(adaptivity) => adaptivity.max_step,
            None => self.options.step,
        };
        let stable = &mut progress.summary.stable_step;
        if stable.is_none_or(|stable| step > stable) {
            *stable = check_step(system, &mut self.stepper, &progress.state, scheme, step)?;
        }
        Ok(())
    }

    /// Starts the energy balance at the present state.
    pub(super) fn open_balance(
        &self,
        system: &mut dyn System,
        progress: &mut Progress,
    ) -> Result<(), DynamicsError> {
        let now = self.energies(system, &progress.state)?;
        progress.summary.energy = now.map(|now| {
            let mut balance = EnergyBalance {
                start: now.kinetic + now.stored,
                ..EnergyBalance::default()
            };
            balance.arrive(&now);
            balance
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
        progress.invariants = match &mut self.projection {
            Some(projection) => {
                Some(projection.set_target(system, &mut self.stepper, progress, until)?)
            }
            None => None,
        };
        Ok(())
    }

    /// Updates the accelerations of the state; see [`Stepper::accelerate`].
    pub(super) fn accelerate(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
        jumps: bool,
    ) -> Result<(), DynamicsError> {
        progress.summary.evaluations += 1;
        progress.summary.factorisations += 1;
        let h = self.options.step.min(progress.next_step);
        (self.stepper).accelerate(system, &mut progress.state, jumps, h)
    }

    pub(super) fn energies(
        &self,
        system: &mut dyn System,
        state: &State,
    ) -> Result<Option<Energies>, DynamicsError> {
        if !self.options.energies && self.projection.is_none() {
            return Ok(None);
        }
        abilities::energies(system, state.point()).map_err(DynamicsError::at(state.t))
    }
}
