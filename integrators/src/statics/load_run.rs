//! Load control with automatic step size.

use super::fixed_load::TangentStatus;
use super::newton::Newton;
use super::options::check;
use super::start::begin;
use super::steps::StaticAnalysis;
use super::{Iteration, StaticOptions, StaticSummary, StaticsError, Step};
use crate::abilities::charts;
use crate::failure::Cause;
use pullback_manifold::system::System;

/// A step of at most this many iterations is followed by one twice as large.
pub(super) const EASY: usize = 5;

/// Largest correction, in sizes of the coordinates, where a prescribed motion moves equations of multipliers: other
/// positions that satisfy them are farther away.
const NEAR: f64 = 0.5;

/// The engine of a run: all that a step needs beside the system.
pub struct LoadRun {
    newton: Newton,
    options: StaticOptions,
    q: Vec<f64>,
    /// Coordinates at the beginning of a step.
    start: Vec<f64>,
    /// Next step of the load parameter.
    dt: f64,
    /// Whether a prescribed motion moves equations of multipliers in the step.
    moved: bool,
    /// The tangent at the present equilibrium; `None` before the first one.
    known: Option<TangentStatus>,
    /// The equilibrium reported last.
    reached: Step<'static>,
}

impl StaticAnalysis for LoadRun {
    type Options = StaticOptions;

    fn new(
        system: &mut dyn System,
        q: Vec<f64>,
        options: &StaticOptions,
    ) -> Result<Self, StaticsError> {
        let numbers = [
            ("from", options.from),
            ("to", options.to),
            ("first_step", options.first_step),
            ("min_step", options.min_step),
            ("max_step", options.max_step),
        ];
        check(&numbers, &options.newton)?;
        let mut newton = Newton::new(system, &options.newton, options.from)?;
        // Without a range there is only the equilibrium at the start.
        newton.summary.finished = options.from == options.to;
        let q = newton.start(q)?;
        let first_step = options.first_step.min(options.max_step);
        Ok(Self {
            newton,
            options: *options,
            start: q.clone(),
            q,
            dt: (options.to - options.from).signum() * first_step,
            moved: false,
            known: None,
            reached: Step::default(),
        })
    }

    /// Goes on to the next equilibrium.
    fn next(&mut self, system: &mut dyn System) -> Result<bool, StaticsError> {
        if self.known.is_none() {
            let (known, start) = begin(&mut self.newton, system, &mut self.q)?;
            self.known = Some(known);
            self.reached = start;
            return Ok(true);
        }
        while let (Some(known), false) = (self.known, self.newton.summary.finished) {
            let rest = self.options.to - self.newton.summary.t;
            // The last step absorbs a tiny remainder.
            let last = rest.abs() <= self.dt.abs() * (1.0 + 1e-9);
            let t = match last {
                true => self.options.to,
                false => self.newton.summary.t + self.dt,
            };
            match self.attempt(system, t, known) {
                Ok(chart_changes) => {
                    self.newton.summary.finished = last;
                    self.accept(system, t, chart_changes);
                    return Ok(true);
                }
                Err(failure) => self.halve(system, t, known, failure)?,
            }
        }
        Ok(false)
    }

    fn report(&self) -> Step<'_> {
        Step {
            q: &self.q,
            residuals: &self.newton.history,
            ..self.reached
        }
    }

    fn q(&self) -> &[f64] {
        &self.q
    }

    fn summary(&self) -> &StaticSummary {
        &self.newton.summary
    }
}

impl LoadRun {
    /// One attempt at a step to `t`; the number of changes of chart.
    fn attempt(
        &mut self,
        system: &mut dyn System,
        t: f64,
        known: TangentStatus,
    ) -> Result<usize, Cause> {
        let (newton, q) = (&mut self.newton, &mut self.q);
        let from = newton.summary.t;
        self.start.copy_from_slice(q);
        self.moved = newton.predict(system, q, [from, t], known)?;
        let far = |history: &[Iteration]| self.moved && history.iter().any(|i| i.correction > NEAR);
        if far(&newton.history) {
            return Err(Cause::OffPath);
        }
        let changes = newton.settle(system, q, t, Some((from, &self.start)))?;
        match far(&newton.history) {
            true => Err(Cause::OffPath),
            false => Ok(changes),
        }
    }

    /// Accepts the equilibrium at `t`.
    fn accept(&mut self, system: &mut dyn System, t: f64, chart_changes: usize) {
        let newton = &mut self.newton;
        let iterations = newton.iterations();
        // The first correction grows with the step.
        let near = !self.moved || 2.0 * newton.history[0].correction <= NEAR;
        let summary = &mut newton.summary;
        summary.steps += 1;
        summary.iterations += iterations;
        summary.chart_changes += chart_changes;
        let (number, step_size) = (summary.steps, t - summary.t);
        summary.t = t;
        // The next step begins with this factorisation: the last one was made at the iterate before.
        let (known, unstable) = newton.prepare(system);
        self.known = Some(known);
        if iterations <= EASY && near {
            let longest = self.options.max_step;
            self.dt = self.dt.signum() * (2.0 * self.dt.abs()).min(longest);
        }
        self.reached = Step {
            number,
            t,
            step_size,
            iterations,
            chart_changes,
            unstable,
            ..Step::default()
        };
    }

    /// Halves the step to `t` after a failure, or ends the run.
    fn halve(
        &mut self,
        system: &mut dyn System,
        t: f64,
        known: TangentStatus,
        failure: Cause,
    ) -> Result<(), StaticsError> {
        // A smaller step would begin with the same tangent, unless this one was extrapolated.
        let exact = known != TangentStatus::Evaluated || self.newton.summary.steps == 0;
        let unpredicted = self.newton.history.is_empty();
        let hopeless = exact && unpredicted && matches!(failure, Cause::Linear { .. });
        self.newton.summary.rejected += 1;
        self.known = Some(TangentStatus::Nothing);
        let mut failed = self.newton.fail(system, failure, t);
        self.q.copy_from_slice(&self.start);
        let from = self.newton.summary.t;
        charts(system).start(from, &self.q);
        charts(system).change_charts(from, &mut self.q, &mut [], &mut []);
        self.dt = 0.5 * (t - from);
        let too_small = self.dt.abs() < self.options.min_step;
        if hopeless || too_small {
            // Leaves the system at the last equilibrium.
            self.newton.evaluate(system, None, &self.q, from).ok();
            failed.min_step = (!hopeless).then_some(self.options.min_step);
            return Err(StaticsError::Step(failed));
        }
        Ok(())
    }
}
