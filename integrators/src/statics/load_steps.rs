//! Load control with automatic step size.

#![allow(non_snake_case)]

use super::error::StaticsError;
use super::fixed_load::{Known, analyse, correct, predict, settle};
use super::newton::Newton;
use super::stability::unstable;
use super::start::begin;
use super::{Converged, StaticNewtonOptions, Step};
use crate::abilities::{change_charts, start};
use crate::failure::Failure;
use crate::linear_solver::{AutoSolver, LinearSolver};
use pullback_manifold::system::System;
use std::ops::{ControlFlow, DerefMut};

/// Load range and step sizes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StaticOptions {
    /// Load parameter at the start.
    pub from: f64,
    /// Load parameter at the end.
    pub to: f64,
    /// First step; it takes the sign of `to − from`.
    pub first_step: f64,
    /// A failed step is halved down to this size; then the analysis fails.
    pub min_step: f64,
    /// Largest step. Equal to `first_step` it gives equal steps (unless one fails).
    pub max_step: f64,
    /// A step of at most this many iterations is followed by one twice as large.
    pub easy: usize,
    /// Newton's method.
    pub newton: StaticNewtonOptions,
}

impl Default for StaticOptions {
    fn default() -> Self {
        Self {
            from: 0.0,
            to: 1.0,
            first_step: 0.1,
            min_step: 1e-6,
            max_step: 0.25,
            easy: 5,
            newton: StaticNewtonOptions::default(),
        }
    }
}

impl StaticOptions {
    /// `count` equal steps from 0 to 1, halved only if one of them fails.
    pub fn equal_steps(count: usize) -> Self {
        let step = 1.0 / count.max(1) as f64;
        Self {
            first_step: step,
            max_step: step,
            ..Self::default()
        }
    }
}

/// Counters and results of an analysis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StaticSummary {
    /// Load parameter reached.
    pub t: f64,
    /// Converged steps.
    pub steps: usize,
    /// Failed attempts.
    pub rejected: usize,
    /// Linear solutions in converged steps.
    pub iterations: usize,
    /// Evaluations of the system.
    pub evaluations: usize,
    /// Factorisations.
    pub factorisations: usize,
    /// Changes of chart.
    pub chart_changes: usize,
    /// Whether the end of the load was reached (an observer may stop earlier).
    pub finished: bool,
}

/// Equilibrium under growing loads, step by step.
///
/// ```text
/// let mut run = LoadSteps::new(&mut context, Vec::new(), &options)?;
/// while let Some(step) = run.step()? { … }
/// ```
///
/// Loads at the start are balanced first, as step 0.
pub struct LoadSteps<S> {
    system: S,
    solver: AutoSolver,
    run: Run,
    q: Vec<f64>,
}

impl<S> LoadSteps<S>
where
    S: DerefMut,
    S::Target: System + Sized,
{
    /// A run from the coordinates `q`; missing ones are zero.
    ///
    /// # Errors
    /// [`StaticsError`] for invalid options.
    pub fn new(
        mut system: S,
        mut q: Vec<f64>,
        options: &StaticOptions,
    ) -> Result<Self, StaticsError> {
        let mut solver = AutoSolver::new();
        let run = Run::new(&mut *system, &mut solver, &mut q, options)?;
        Ok(Self {
            system,
            solver,
            run,
            q,
        })
    }

    /// The next equilibrium; `None` at the end of the load range.
    ///
    /// # Errors
    /// [`StaticsError`] with the failed step, its load, the cause and the residuals.
    pub fn step(&mut self) -> Result<Option<Step<'_>>, StaticsError> {
        let step = (self.run).next(&mut *self.system, &mut self.solver, &mut self.q)?;
        Ok(step.map(|step| step.report(&self.q, &self.run.newton.history)))
    }

    /// All steps to the end of the load range.
    ///
    /// # Errors
    /// As [`LoadSteps::step`].
    pub fn finish(&mut self) -> Result<(), StaticsError> {
        while self.step()?.is_some() {}
        Ok(())
    }

    /// The present coordinates.
    pub fn q(&self) -> &[f64] {
        &self.q
    }

    /// Counters so far.
    pub fn summary(&self) -> &StaticSummary {
        &self.run.summary
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

/// Follows the equilibrium of `system` from `q` over the load range, with the default solver: all
/// steps of [`LoadSteps`]. The observer is called after each and may stop the run.
///
/// # Errors
/// [`StaticsError`] with the failed step, its load, the cause and the residuals.
pub fn solve_statics<Y: System>(
    system: &mut Y,
    q: &mut Vec<f64>,
    options: &StaticOptions,
    observer: &mut dyn FnMut(&mut Y, &Step<'_>) -> ControlFlow<()>,
) -> Result<StaticSummary, StaticsError> {
    solve_statics_with(&mut AutoSolver::new(), system, q, options, observer)
}

/// The equilibrium of `system` at the end of the load range, from zero coordinates.
///
/// # Errors
/// As [`solve_statics`].
pub fn equilibrium(
    system: &mut dyn System,
    options: &StaticOptions,
) -> Result<Vec<f64>, StaticsError> {
    let (mut solver, mut q) = (AutoSolver::new(), Vec::new());
    let mut run = Run::new(system, &mut solver, &mut q, options)?;
    while run.next(system, &mut solver, &mut q)?.is_some() {}
    Ok(q)
}

/// As [`solve_statics`], with another linear solver.
///
/// # Errors
/// As [`solve_statics`].
pub fn solve_statics_with<Y: System>(
    solver: &mut dyn LinearSolver,
    system: &mut Y,
    q: &mut Vec<f64>,
    options: &StaticOptions,
    observer: &mut dyn FnMut(&mut Y, &Step<'_>) -> ControlFlow<()>,
) -> Result<StaticSummary, StaticsError> {
    let mut run = Run::new(system, solver, q, options)?;
    while let Some(step) = run.next(system, solver, q)? {
        if observer(system, &step.report(q, &run.newton.history)).is_break() {
            break;
        }
    }
    Ok(run.summary)
}

/// The engine of a run: all that a step needs beside the system, the solver and the coordinates.
struct Run {
    newton: Newton,
    options: StaticOptions,
    summary: StaticSummary,
    /// Coordinates at the beginning of a step.
    start: Vec<f64>,
    /// Next step of the load parameter.
    dt: f64,
    /// The tangent at the present equilibrium; `None` before the first one.
    known: Option<Known>,
}

impl Run {
    fn new(
        system: &mut dyn System,
        solver: &mut dyn LinearSolver,
        q: &mut Vec<f64>,
        options: &StaticOptions,
    ) -> Result<Self, StaticsError> {
        check(options)?;
        q.resize(system.pattern().dim(), 0.0);
        analyse(solver, system)?;
        let first_step = options.first_step.abs().min(options.max_step.abs());
        Ok(Self {
            newton: Newton::new(system, &options.newton),
            options: *options,
            summary: StaticSummary {
                t: options.from,
                ..StaticSummary::default()
            },
            start: q.clone(),
            dt: (options.to - options.from).signum() * first_step,
            known: None,
        })
    }

    /// The next equilibrium; `None` at the end of the load range.
    fn next(
        &mut self,
        system: &mut dyn System,
        solver: &mut dyn LinearSolver,
        q: &mut [f64],
    ) -> Result<Option<Converged>, StaticsError> {
        if self.known.is_none() {
            let (known, start) = begin(&mut self.newton, solver, system, q, &mut self.summary)?;
            self.known = Some(known);
            if start.is_some() {
                return Ok(start);
            }
        }
        while !self.summary.finished {
            let rest = self.options.to - self.summary.t;
            // The last step absorbs a tiny remainder.
            let last = rest.abs() <= self.dt.abs() * (1.0 + 1e-9);
            let t = if last {
                self.options.to
            } else {
                self.summary.t + self.dt
            };
            let known = self.known.unwrap_or(Known::Nothing);
            let attempt = self.attempt(system, solver, q, t, known);
            self.summary.evaluations = self.newton.evaluations;
            self.summary.factorisations = self.newton.factorisations;
            match attempt {
                Ok(chart_changes) => {
                    self.summary.finished = last;
                    return Ok(Some(self.accept(system, solver, t, chart_changes)));
                }
                Err(failure) => self.halve(system, q, t, known, failure)?,
            }
        }
        Ok(None)
    }

    /// One attempt at a step to `t`; the number of changes of chart.
    fn attempt(
        &mut self,
        system: &mut dyn System,
        solver: &mut dyn LinearSolver,
        q: &mut [f64],
        t: f64,
        known: Known,
    ) -> Result<usize, StepFailure> {
        let newton = &mut self.newton;
        self.start.copy_from_slice(q);
        newton.history.clear();
        let from = self.summary.t;
        predict(newton, solver, system, q, [from, t], known).map_err(StepFailure::Predict)?;
        let previous = Some((from, self.start.as_slice()));
        correct(newton, solver, system, q, t, previous)
            .and_then(|()| settle(newton, solver, system, q, t))
            .map_err(StepFailure::Correct)
    }

    /// Accepts the equilibrium at `t`.
    fn accept(
        &mut self,
        system: &mut dyn System,
        solver: &mut dyn LinearSolver,
        t: f64,
        chart_changes: usize,
    ) -> Converged {
        let (newton, summary) = (&mut self.newton, &mut self.summary);
        let iterations = newton.iterations();
        summary.steps += 1;
        summary.iterations += iterations;
        summary.chart_changes += chart_changes;
        let step_size = t - summary.t;
        summary.t = t;
        // The next step begins with this factorisation, made at the iterate before the last. A
        // singular tangent fails the next step, if any.
        self.known = Some(Known::Evaluated);
        let mut stability = None;
        if system.is_symmetric() && newton.factorise(solver).is_ok() {
            self.known = Some(Known::Factorised);
            stability = unstable(newton, solver, system);
        }
        summary.factorisations = newton.factorisations;
        if iterations <= self.options.easy {
            let longest = self.options.max_step.abs();
            self.dt = self.dt.signum() * (2.0 * self.dt.abs()).min(longest);
        }
        Converged {
            number: summary.steps,
            t,
            step_size,
            iterations,
            chart_changes,
            unstable: stability,
        }
    }

    /// Halves the step to `t` after a failure, or ends the run.
    fn halve(
        &mut self,
        system: &mut dyn System,
        q: &mut [f64],
        t: f64,
        known: Known,
        failure: StepFailure,
    ) -> Result<(), StaticsError> {
        // A smaller step would begin with the same tangent, unless this one was extrapolated.
        let exact = known != Known::Evaluated || self.summary.steps == 0;
        let hopeless = exact && matches!(failure, StepFailure::Predict(Failure::Linear(_)));
        let (StepFailure::Predict(failure) | StepFailure::Correct(failure)) = failure;
        self.summary.rejected += 1;
        self.known = Some(Known::Nothing);
        let mut failed = self.newton.fail(system, failure, &self.summary, t);
        q.copy_from_slice(&self.start);
        start(system, self.summary.t, q);
        change_charts(system, self.summary.t, q, &mut [], &mut []);
        self.dt = 0.5 * (t - self.summary.t);
        if hopeless {
            return Err(StaticsError::Step(failed));
        }
        if self.dt.abs() < self.options.min_step.abs() || self.dt == 0.0 {
            failed.min_step = Some(self.options.min_step);
            return Err(StaticsError::Step(failed));
        }
        Ok(())
    }
}

/// The part of a step that failed.
enum StepFailure {
    Predict(Failure),
    Correct(Failure),
}

fn check(options: &StaticOptions) -> Result<(), StaticsError> {
    let numbers = [
        ("from", options.from),
        ("to", options.to),
        ("first_step", options.first_step),
        ("min_step", options.min_step),
        ("max_step", options.max_step),
    ];
    for (name, value) in numbers {
        if !value.is_finite() || (name.ends_with("step") && value <= 0.0) {
            return Err(StaticsError::Option { name, value });
        }
    }
    match options.newton.refused() {
        Some((name, value)) => Err(StaticsError::Option { name, value }),
        None => Ok(()),
    }
}
