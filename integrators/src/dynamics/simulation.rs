//! A motion step by step, and the loop over all of its steps.

use super::events::UserEvent;
use super::run::MotionRun;
use super::{DynamicOptions, DynamicsError, Progress, State, StepReport};
use crate::abilities::events;
use pullback_manifold::system::System;
use std::ops::{ControlFlow, Deref, DerefMut};

/// A motion, step by step.
///
/// ```text
/// let mut run = Simulation::new(&mut context, state, options)?;
/// while let Some(step) = run.step()? { … }
/// ```
///
/// `S` is a reference to a [`System`], or a box with one. Between steps inputs may be set, and the
/// configuration may be queried.
pub struct Simulation<S>
where
    S: Deref<Target: Sized>,
{
    system: S,
    events: Vec<UserEvent<S::Target>>,
    run: MotionRun,
    progress: Progress,
}

/// A system, the progress of its run and its options: everything that the next step depends on.
#[derive(Clone, Debug)]
pub struct Snapshot<Y> {
    /// The system, with its charts.
    pub system: Y,
    /// The progress.
    pub progress: Progress,
    /// The options, with the present size of steps.
    pub options: DynamicOptions,
}

impl<S> Simulation<S>
where
    S: DerefMut,
    S::Target: System + Sized,
{
    /// A motion from a state (see [`start`](super::start)).
    ///
    /// # Errors
    /// [`DynamicsError`] for invalid options, a state of another system, and accelerations that
    /// cannot be found.
    pub fn new(system: S, state: State, options: &DynamicOptions) -> Result<Self, DynamicsError> {
        Self::resume(system, Progress::new(state), options)
    }

    /// Continues from the progress of an earlier run of the same system. Its events are to be added again, in their
    /// order; for other ones clear [`Progress::events`] before.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn resume(
        mut system: S,
        mut progress: Progress,
        options: &DynamicOptions,
    ) -> Result<Self, DynamicsError> {
        let run = MotionRun::new(&mut *system, &mut progress, options)?;
        Ok(Self {
            system,
            events: Vec::new(),
            run,
            progress,
        })
    }

    /// The next step; `None` at the end of the run.
    ///
    /// # Errors
    /// [`DynamicsError`]; the run is then at the last accepted step.
    pub fn step(&mut self) -> Result<Option<StepReport<'_>>, DynamicsError> {
        let (events, progress) = (&mut self.events, &mut self.progress);
        self.run.next(&mut *self.system, events, progress)
    }

    /// Adds an event, which occurs where its value crosses zero from below (for the other direction,
    /// take its negative); returns its number, from 0 in the order of addition.
    ///
    /// A step ends there, to round-off. The effect is then applied to the system, at this state, and
    /// to the state: it may set inputs, and change velocities as an impact does, but not the time. Accelerations follow
    /// from the equations of motion, and energy that has come or gone counts as work. If the effect
    /// returns [`ControlFlow::Break`], the run ends.
    ///
    /// A value that crosses zero and returns within a step goes unnoticed, except just after an
    /// event: a ball that bounces several times in a step is seen each time. What occurs within 1e-8
    /// of a step after its beginning occurs at that time. Values of 0 at the start are not crossings. Of infinitely many
    /// events in a finite time, as of a ball that comes to rest, the last ones are lost in rounding errors, and the ball
    /// falls through its floor: let the effect end the run, or hold the ball by an input, when its velocity is small. A thousand
    /// in a row that end steps before a hundredth of their size are an error.
    ///
    /// Events are no part of a [`Snapshot`], apart from what is needed for the same steps.
    pub fn add_event(
        &mut self,
        value: impl FnMut(&S::Target, &State) -> f64 + Send + 'static,
        apply: impl FnMut(&mut S::Target, &mut State) -> ControlFlow<()> + Send + 'static,
    ) -> usize {
        self.events.push(UserEvent {
            value: Box::new(value),
            apply: Box::new(apply),
        });
        self.events.len() - 1
    }

    /// All steps to the end of the run.
    ///
    /// # Errors
    /// As [`Simulation::step`].
    pub fn finish(&mut self) -> Result<(), DynamicsError> {
        while self.step()?.is_some() {}
        Ok(())
    }

    /// The present state of motion.
    pub fn state(&self) -> &State {
        &self.progress.state
    }

    /// The progress: state, counters, energy balance.
    pub fn progress(&self) -> &Progress {
        &self.progress
    }

    /// The system, at the present state.
    pub fn system(&self) -> &S::Target {
        &self.system
    }

    /// The system, for questions that evaluate it.
    pub fn system_mut(&mut self) -> &mut S::Target {
        &mut self.system
    }

    /// Sets an input of the system, from the next step on.
    ///
    /// A coordinate that an input prescribes jumps to its new value with all that is attached to it, without a velocity:
    /// that motion causes no inertia. Move such parts by an actuator, or by a spring to a massless node.
    /// What the system answers until that step mixes the forces of new inputs with the accelerations before.
    ///
    /// # Panics
    /// If the system has no such input.
    pub fn set_input(&mut self, input: impl Into<usize>, value: f64) {
        events(&mut *self.system).inputs()[input.into()] = value;
    }

    /// Sets the size of the steps from the next one on; adaptive steps begin with it.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn set_step(&mut self, step: f64) -> Result<(), DynamicsError> {
        if step == self.run.options.step && step == self.progress.next_step {
            return Ok(());
        }
        self.run
            .set_step(&mut *self.system, &mut self.progress, step)
    }

    /// A copy of everything that the next step depends on.
    pub fn save(&self) -> Snapshot<S::Target>
    where
        S::Target: Clone,
    {
        Snapshot {
            system: self.system.clone(),
            progress: self.progress.clone(),
            options: self.run.options,
        }
    }

    /// Goes back to a snapshot of the same system. The steps from there are the same to the last bit; a run that an event
    /// has ended goes on.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn restore(&mut self, snapshot: &Snapshot<S::Target>) -> Result<(), DynamicsError>
    where
        S::Target: Clone,
    {
        let (mut system, mut progress) = (snapshot.system.clone(), snapshot.progress.clone());
        self.run = MotionRun::new(&mut system, &mut progress, &snapshot.options)?;
        (*self.system, self.progress) = (system, progress);
        Ok(())
    }
}

/// Integrates the equations of motion from `progress`: all steps of a [`Simulation`].
///
/// The observer is called after each accepted step and may stop the run.
///
/// # Errors
/// [`DynamicsError`]; `progress` is then at the last accepted step.
pub fn integrate<Y: System>(
    system: &mut Y,
    progress: &mut Progress,
    options: &DynamicOptions,
    observer: &mut dyn FnMut(&mut Y, &StepReport<'_>) -> ControlFlow<()>,
) -> Result<(), DynamicsError> {
    let mut run = MotionRun::new(system, progress, options)?;
    while let Some(step) = run.next(system, &mut [], progress)? {
        if observer(system, &step).is_break() {
            break;
        }
    }
    Ok(())
}
