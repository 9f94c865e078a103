//! Path following: options, results, and the path step by step.

use super::error::StaticsError;
use super::path_run::Run;
use super::{StaticNewtonOptions, StaticSummary, Step};
use crate::linear_solver::{AutoSolver, LinearSolver};
use pullback_manifold::system::System;
use std::ops::{ControlFlow, DerefMut};

/// An event to locate and report on the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// The load has a maximum or minimum.
    TurningPoint,
    /// The load parameter passes a value.
    Load(f64),
    /// A coordinate passes a value.
    Coordinate {
        /// Which unknown.
        unknown: usize,
        /// Its value.
        value: f64,
    },
}

/// Options of [`trace_path`](super::trace_path).
#[derive(Clone, Debug, PartialEq)]
pub struct ArcLengthOptions {
    /// Load parameter at the start.
    pub from: f64,
    /// First step along the path. With the default scale, 0.05 changes the load by at most 0.05.
    pub first_step: f64,
    /// Largest step along the path.
    pub max_step: f64,
    /// A failed step is halved until it is smaller than this.
    pub min_step: f64,
    /// Largest number of steps.
    pub max_steps: usize,
    /// Change of the load parameter that counts as much as a change of the coordinates by their scales.
    pub load_scale: f64,
    /// Desired number of iterations of a step; fewer make the next one larger, more make it smaller.
    pub target_iterations: usize,
    /// Events to locate and report, each with whether it ends the path.
    pub events: Vec<(Event, bool)>,
    /// Direction of the load at the start: true for growing.
    pub forward: bool,
    /// Newton's method.
    pub newton: StaticNewtonOptions,
}

impl Default for ArcLengthOptions {
    fn default() -> Self {
        Self {
            from: 0.0,
            first_step: 0.05,
            max_step: 0.1,
            min_step: 1e-7,
            max_steps: 500,
            load_scale: 1.0,
            target_iterations: 5,
            events: vec![(Event::Load(1.0), true)],
            forward: true,
            newton: StaticNewtonOptions::default(),
        }
    }
}

/// Results of path following.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathSummary {
    /// Counters as in load stepping; `finished` says that an ending event was reached.
    pub summary: StaticSummary,
    /// Events in order: index and load parameter.
    pub events: Vec<(usize, f64)>,
}

/// An equilibrium path, step by step, with located events between the steps.
///
/// ```text
/// let mut path = PathSteps::new(&mut context, Vec::new(), &options)?;
/// while let Some(step) = path.step()? { … }
/// ```
///
/// Loads at the start are balanced first, as step 0.
pub struct PathSteps<S> {
    system: S,
    solver: AutoSolver,
    run: Run,
}

impl<S> PathSteps<S>
where
    S: DerefMut,
    S::Target: System + Sized,
{
    /// A path from the coordinates `q`; missing ones are zero.
    ///
    /// # Errors
    /// [`StaticsError`] for invalid options.
    pub fn new(
        mut system: S,
        q: Vec<f64>,
        options: &ArcLengthOptions,
    ) -> Result<Self, StaticsError> {
        let mut solver = AutoSolver::new();
        let run = Run::new(&mut *system, &mut solver, q, options)?;
        Ok(Self {
            system,
            solver,
            run,
        })
    }

    /// The next equilibrium or event; `None` at the end of the path.
    ///
    /// # Errors
    /// [`StaticsError`] with the failed step, its load, the cause and the residuals.
    pub fn step(&mut self) -> Result<Option<Step<'_>>, StaticsError> {
        let more = (self.run).next(&mut *self.system, &mut self.solver)?;
        Ok(more.then(|| self.run.reached.report()))
    }

    /// The present coordinates.
    pub fn q(&self) -> &[f64] {
        self.run.q()
    }

    /// Counters and events so far.
    pub fn summary(&self) -> &PathSummary {
        &self.run.out
    }

    /// The system, at the present equilibrium.
    pub fn system(&self) -> &S::Target {
        &self.system
    }

    /// The system, for questions that evaluate it.
    pub fn system_mut(&mut self) -> &mut S::Target {
        &mut self.system
    }
}

/// Follows the equilibrium path of `system` from `q`, with the default solver: all steps of
/// [`PathSteps`]. The observer is called after each and may stop the run.
///
/// # Errors
/// [`StaticsError`] with the failed step, its load, the cause and the residuals.
pub fn trace_path<Y: System>(
    system: &mut Y,
    q: &mut Vec<f64>,
    options: &ArcLengthOptions,
    observer: &mut dyn FnMut(&mut Y, &Step<'_>) -> ControlFlow<()>,
) -> Result<PathSummary, StaticsError> {
    trace_path_with(&mut AutoSolver::new(), system, q, options, observer)
}

/// As [`trace_path`], with another linear solver.
///
/// # Errors
/// As [`trace_path`].
pub fn trace_path_with<Y: System>(
    solver: &mut dyn LinearSolver,
    system: &mut Y,
    q: &mut Vec<f64>,
    options: &ArcLengthOptions,
    observer: &mut dyn FnMut(&mut Y, &Step<'_>) -> ControlFlow<()>,
) -> Result<PathSummary, StaticsError> {
    let mut run = Run::new(system, solver, std::mem::take(q), options)?;
    let outcome = loop {
        match run.next(system, solver) {
            Ok(true) => {}
            Ok(false) => break Ok(()),
            Err(error) => break Err(error),
        }
        if observer(system, &run.reached.report()).is_break() {
            run.out.summary.t = run.reached.step.t;
            break Ok(());
        }
    };
    *q = run.q().to_vec();
    outcome.map(|()| run.out)
}
