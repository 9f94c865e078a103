//! Equilibria one after the other, and the loop over all of them.

use super::load_run::LoadRun;
use super::path_run::PathRun;
use super::{ArcLengthOptions, StaticOptions, StaticSummary, StaticsError, Step};
use pullback_manifold::system::System;
use std::ops::{ControlFlow, DerefMut};

/// The engine of an analysis: all that a step needs beside the system.
pub trait StaticAnalysis: Sized {
    /// Its options.
    type Options;

    /// An analysis from the coordinates `q`; missing ones are zero.
    fn new(
        system: &mut dyn System,
        q: Vec<f64>,
        options: &Self::Options,
    ) -> Result<Self, StaticsError>;

    /// Goes on to the next equilibrium; false at the end.
    fn next(&mut self, system: &mut dyn System) -> Result<bool, StaticsError>;

    /// The equilibrium reached last.
    fn report(&self) -> Step<'_>;

    /// The present coordinates.
    fn q(&self) -> &[f64];

    /// Counters so far.
    fn summary(&self) -> &StaticSummary;
}

/// Equilibria step by step: under growing loads ([`LoadSteps`]) or along a path ([`PathSteps`]).
///
/// ```text
/// let mut run = LoadSteps::new(&mut context, Vec::new(), &options)?;
/// while let Some(step) = run.step()? { … }
/// ```
///
/// The first one is the equilibrium at the start, as step 0.
pub struct Steps<S, A> {
    system: S,
    analysis: A,
}

/// Equilibrium under growing loads, step by step: see [`Steps`].
pub type LoadSteps<S> = Steps<S, LoadRun>;

/// An equilibrium path, step by step, with located events between the steps: see [`Steps`].
pub type PathSteps<S> = Steps<S, PathRun>;

impl<S, A: StaticAnalysis> Steps<S, A>
where
    S: DerefMut,
    S::Target: System + Sized,
{
    /// An analysis from the coordinates `q`; missing ones are zero.
    ///
    /// # Errors
    /// [`StaticsError`] for invalid options.
    pub fn new(mut system: S, q: Vec<f64>, options: &A::Options) -> Result<Self, StaticsError> {
        let analysis = A::new(&mut *system, q, options)?;
        Ok(Self { system, analysis })
    }

    /// The next equilibrium or event; `None` at the end of the load range or path.
    ///
    /// # Errors
    /// [`StaticsError`] with the failed step, its load, the cause and the residuals. The system is then at the last
    /// equilibrium.
    pub fn step(&mut self) -> Result<Option<Step<'_>>, StaticsError> {
        let more = self.analysis.next(&mut *self.system)?;
        Ok(more.then(|| self.analysis.report()))
    }

    /// All steps to the end.
    ///
    /// # Errors
    /// As [`Steps::step`].
    pub fn finish(&mut self) -> Result<(), StaticsError> {
        while self.step()?.is_some() {}
        Ok(())
    }

    /// The present coordinates.
    pub fn q(&self) -> &[f64] {
        self.analysis.q()
    }

    /// Counters so far.
    pub fn summary(&self) -> &StaticSummary {
        self.analysis.summary()
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

/// All steps of an analysis from `q`, which ends as the coordinates reached.
fn run<A: StaticAnalysis, Y: System>(
    system: &mut Y,
    q: &mut Vec<f64>,
    options: &A::Options,
    observer: &mut dyn FnMut(&mut Y, &Step<'_>) -> ControlFlow<()>,
) -> Result<StaticSummary, StaticsError> {
    let mut analysis = A::new(system, q.clone(), options)?;
    let outcome = loop {
        match analysis.next(system) {
            Ok(true) if observer(system, &analysis.report()).is_continue() => {}
            Ok(_) => break Ok(()),
            Err(error) => break Err(error),
        }
    };
    *q = analysis.q().to_vec();
    outcome.map(|()| analysis.summary().clone())
}

/// Follows the equilibrium of `system` from `q` over the load range: all steps of [`LoadSteps`].
/// The observer is called after each and may stop the run.
///
/// # Errors
/// [`StaticsError`] with the failed step, its load, the cause and the residuals.
pub fn solve_statics<Y: System>(
    system: &mut Y,
    q: &mut Vec<f64>,
    options: &StaticOptions,
    observer: &mut dyn FnMut(&mut Y, &Step<'_>) -> ControlFlow<()>,
) -> Result<StaticSummary, StaticsError> {
    run::<LoadRun, Y>(system, q, options, observer)
}

/// The equilibrium of `system` at the end of the load range, from zero coordinates.
///
/// # Errors
/// As [`solve_statics`].
pub fn equilibrium(
    system: &mut dyn System,
    options: &StaticOptions,
) -> Result<Vec<f64>, StaticsError> {
    equilibrium_from(system, Vec::new(), options)
}

/// The equilibrium at the end of the load range, from the coordinates `q` at its start.
pub(crate) fn equilibrium_from(
    system: &mut dyn System,
    q: Vec<f64>,
    options: &StaticOptions,
) -> Result<Vec<f64>, StaticsError> {
    let mut run = LoadRun::new(system, q, options)?;
    while run.next(system)? {}
    Ok(run.q().to_vec())
}

/// Follows the equilibrium path of `system` from `q`: all steps of [`PathSteps`]. The observer is
/// called after each and may stop the run.
///
/// # Errors
/// [`StaticsError`] with the failed step, its load, the cause and the residuals.
pub fn trace_path<Y: System>(
    system: &mut Y,
    q: &mut Vec<f64>,
    options: &ArcLengthOptions,
    observer: &mut dyn FnMut(&mut Y, &Step<'_>) -> ControlFlow<()>,
) -> Result<StaticSummary, StaticsError> {
    run::<PathRun, Y>(system, q, options, observer)
}
