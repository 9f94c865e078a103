//! The engine of path following: steps along the path, their events, and their size.

#![allow(non_snake_case)]

use super::arc_length::{Norm, Position, SHARPEST_BEND, advance, tangent};
use super::error::StaticsError;
use super::fixed_load::analyse;
use super::locate::{Located, locate};
use super::newton::Newton;
use super::path::{ArcLengthOptions, PathSummary};
use super::stability::unstable;
use super::start::begin;
use super::{Converged, Iteration, Step};
use crate::abilities::change_charts;
use crate::failure::Failure;
use crate::linear_solver::LinearSolver;
use pullback_manifold::system::{ChartChanges, System};

/// Cosine below which the next step is shorter.
const GENTLE_BEND: f64 = 0.9;

/// The engine of a path: all that a step needs beside the system and the solver.
pub(super) struct Run {
    newton: Newton,
    norm: Norm,
    options: ArcLengthOptions,
    pub out: PathSummary,
    at: Position,
    next: Position,
    ds: f64,
    phase: Phase,
    /// Whether the tangent at the present position is known.
    fresh: bool,
    /// Changes of chart not reported yet.
    changes: usize,
    /// The equilibrium reported last.
    pub reached: Reached,
}

/// What comes next on a path.
enum Phase {
    /// The equilibrium under the loads at the start.
    Begin,
    /// A step.
    Advance,
    /// The events and the end of a converged step.
    Report(Converging),
    /// The preparation of the next step, after one of so many iterations and this cosine of its bend.
    Prepare(usize, f64),
    End,
}

/// A converged step whose events and end are not reported yet.
struct Converging {
    located: std::vec::IntoIter<Located>,
    /// Whether there were any events.
    moved: bool,
    iterations: usize,
    /// Iterations that the last row reports besides its own.
    untold: usize,
    history: Vec<Iteration>,
    bend: f64,
    unstable: Option<usize>,
}

/// A reported equilibrium.
pub(super) struct Reached {
    pub step: Converged,
    event: Option<usize>,
    q: Vec<f64>,
    history: Vec<Iteration>,
}

impl Reached {
    pub fn report(&self) -> Step<'_> {
        Step {
            event: self.event,
            ..self.step.report(&self.q, &self.history)
        }
    }
}

impl Run {
    pub fn new(
        system: &mut dyn System,
        solver: &mut dyn LinearSolver,
        mut q: Vec<f64>,
        options: &ArcLengthOptions,
    ) -> Result<Self, StaticsError> {
        check(options)?;
        let n = system.pattern().dim();
        q.resize(n, 0.0);
        analyse(solver, system)?;
        let newton = Newton::new(system, &options.newton);
        let weights = newton.inverse_scale.iter().map(|s| s * s / n as f64);
        let norm = Norm {
            weights: weights.collect(),
            load: 1.0 / (options.load_scale * options.load_scale),
        };
        let mut out = PathSummary::default();
        out.summary.t = options.from;
        let at = Position {
            q,
            lambda: options.from,
            dq: vec![0.0; n],
            d_lambda: if options.forward { 1.0 } else { -1.0 },
        };
        Ok(Self {
            newton,
            norm,
            out,
            next: at.clone(),
            at,
            ds: options.first_step,
            phase: Phase::Begin,
            fresh: false,
            changes: 0,
            reached: Reached {
                step: Converged::default(),
                event: None,
                q: Vec::new(),
                history: Vec::new(),
            },
            options: options.clone(),
        })
    }

    /// The coordinates of the last event if the run ended there, of the last step otherwise.
    pub fn q(&self) -> &[f64] {
        match self.reached.event {
            Some(_) => &self.reached.q,
            None => &self.at.q,
        }
    }

    /// Goes on to the next equilibrium or event; false at the end of the path.
    pub fn next(
        &mut self,
        system: &mut dyn System,
        solver: &mut dyn LinearSolver,
    ) -> Result<bool, StaticsError> {
        loop {
            match std::mem::replace(&mut self.phase, Phase::Advance) {
                Phase::Begin => {
                    let summary = &mut self.out.summary;
                    let q = &mut self.at.q;
                    let (_, start) = begin(&mut self.newton, solver, system, q, summary)?;
                    if let Some(step) = start {
                        self.reached = Reached {
                            step,
                            event: None,
                            q: self.at.q.clone(),
                            history: self.newton.history.clone(),
                        };
                        return Ok(true);
                    }
                }
                Phase::Advance if self.out.summary.steps >= self.options.max_steps => {
                    self.phase = Phase::End;
                }
                Phase::Advance => self.advance(system, solver)?,
                Phase::Report(mut converging) => {
                    match converging.located.next() {
                        Some(found) => self.report_event(system, found, converging)?,
                        None => self.accept(system, converging),
                    }
                    return Ok(true);
                }
                Phase::Prepare(iterations, bend) => self.prepare(system, iterations, bend),
                Phase::End => {
                    self.phase = Phase::End;
                    return Ok(false);
                }
            }
        }
    }

    /// One attempt at a step; a failed one is halved.
    fn advance(
        &mut self,
        system: &mut dyn System,
        solver: &mut dyn LinearSolver,
    ) -> Result<(), StaticsError> {
        let (newton, at, next) = (&mut self.newton, &mut self.at, &mut self.next);
        newton.history.clear();
        let mut outcome = Ok(());
        let mut hopeless = false;
        if !self.fresh {
            let changed = change_charts(system, at.lambda, &mut at.q, &mut at.dq, &mut []);
            self.changes += changed.charts;
            outcome = tangent(newton, solver, system, at, &self.norm);
            // A smaller step would begin with the same tangent.
            hopeless = outcome.is_err();
        }
        let ds = self.ds;
        if outcome.is_ok() {
            outcome = advance(newton, solver, system, at, ds, &self.norm, next);
        }
        let iterations = newton.iterations();
        let history = newton.history.clone();
        if outcome.is_ok() {
            next.dq.copy_from_slice(&at.dq);
            next.d_lambda = at.d_lambda;
            outcome = tangent(newton, solver, system, next, &self.norm);
        }
        let norm = &self.norm;
        let bend = norm.dot((&at.dq, at.d_lambda), (&next.dq, next.d_lambda));
        outcome = match outcome {
            // The last step must also arrive from its other end.
            Ok(())
                if bend < SHARPEST_BEND
                    || norm.strays(at, next, ds)
                    || norm.strays(next, at, -ds) =>
            {
                Err(Failure::OffPath)
            }
            Err(Failure::Diverged) => Err(Failure::OffPath),
            outcome => outcome,
        };
        let mut stability = None;
        let located = outcome.and_then(|()| {
            stability = unstable(newton, solver, system);
            locate(newton, solver, system, (at, next, ds), norm, &self.options)
        });
        self.out.summary.evaluations = newton.evaluations;
        self.out.summary.factorisations = newton.factorisations;
        let located = match located {
            Ok(located) => located,
            Err(failure) => return self.halve(system, failure, hopeless),
        };
        self.out.summary.steps += 1;
        self.out.summary.chart_changes += self.changes;
        self.phase = Phase::Report(Converging {
            moved: !located.is_empty(),
            untold: iterations + located.iter().map(|l| l.iterations).sum::<usize>(),
            located: located.into_iter(),
            iterations,
            history,
            bend,
            unstable: stability,
        });
        Ok(())
    }

    /// Halves the step after a failure, or ends the path.
    fn halve(
        &mut self,
        system: &mut dyn System,
        failure: Failure,
        hopeless: bool,
    ) -> Result<(), StaticsError> {
        self.out.summary.rejected += 1;
        self.fresh = false;
        let to = self.at.lambda + self.ds * self.at.d_lambda;
        let mut failed = self.newton.fail(system, failure, &self.out.summary, to);
        self.ds *= 0.5;
        if self.ds < self.options.min_step || hopeless {
            failed.min_step = (!hopeless).then_some(self.options.min_step);
            return Err(StaticsError::Step(failed));
        }
        Ok(())
    }

    /// Reports an event of a converged step.
    fn report_event(
        &mut self,
        system: &mut dyn System,
        found: Located,
        mut step: Converging,
    ) -> Result<(), StaticsError> {
        let last = self.options.events[found.index].1;
        let spent = if last { step.untold } else { found.iterations };
        step.untold -= spent;
        let summary = &mut self.out.summary;
        summary.iterations += spent;
        let Position { q, lambda, .. } = found.position;
        self.out.events.push((found.index, lambda));
        let newton = &mut self.newton;
        newton
            .evaluate(system, None, &q, lambda)
            .map_err(|source| {
                let failure = Failure::System(source);
                StaticsError::Step(newton.fail(system, failure, summary, lambda))
            })?;
        self.reached = Reached {
            step: Converged {
                number: summary.steps,
                t: lambda,
                step_size: found.s,
                iterations: spent,
                chart_changes: self.changes,
                unstable: found.unstable,
            },
            event: Some(found.index),
            q,
            history: found.history,
        };
        self.phase = if last {
            summary.t = lambda;
            summary.finished = true;
            Phase::End
        } else {
            Phase::Report(step)
        };
        Ok(())
    }

    /// Accepts and reports the end of a converged step.
    fn accept(&mut self, system: &mut dyn System, step: Converging) {
        std::mem::swap(&mut self.at, &mut self.next);
        let (at, summary) = (&self.at, &mut self.out.summary);
        summary.iterations += step.iterations;
        summary.t = at.lambda;
        if step.moved {
            // Locating events has moved the system: restore it.
            (self.newton.evaluate(system, None, &at.q, at.lambda)).ok();
        }
        self.reached = Reached {
            step: Converged {
                number: summary.steps,
                t: at.lambda,
                step_size: self.ds,
                iterations: step.iterations,
                chart_changes: self.changes,
                unstable: step.unstable,
            },
            event: None,
            q: at.q.clone(),
            history: step.history,
        };
        self.phase = Phase::Prepare(step.iterations, step.bend);
    }

    /// Changes charts after a step, and chooses the size of the next one.
    fn prepare(&mut self, system: &mut dyn System, iterations: usize, bend: f64) {
        let at = &mut self.at;
        // The next step uses this tangent, unless charts change.
        let changed = change_charts(system, at.lambda, &mut at.q, &mut at.dq, &mut []);
        self.changes = changed.charts;
        self.fresh = changed == ChartChanges::default();
        let ease = (self.options.target_iterations as f64 / iterations.max(1) as f64).sqrt();
        let straightness = if bend < GENTLE_BEND { 0.7 } else { 1.5 };
        self.ds = (self.ds * ease.clamp(0.5, straightness)).min(self.options.max_step);
    }
}

fn check(options: &ArcLengthOptions) -> Result<(), StaticsError> {
    let numbers = [
        ("first_step", options.first_step),
        ("min_step", options.min_step),
        ("max_step", options.max_step),
        ("load_scale", options.load_scale),
    ];
    for (name, value) in numbers {
        if !(value.is_finite() && value > 0.0) {
            return Err(StaticsError::Option { name, value });
        }
    }
    match options.newton.refused() {
        Some((name, value)) => Err(StaticsError::Option { name, value }),
        None => Ok(()),
    }
}
