//! The engine of path following: steps along the path, their events, and their size.

use super::arc_length::{Norm, Position};
use super::critical::PathDirection;
use super::locate::Located;
use super::newton::Newton;
use super::options::check;
use super::path_attempt::{Converging, off_path};
use super::start::{balance, begin};
use super::steps::StaticAnalysis;
use super::{ArcLengthOptions, Event, Iteration, StaticSummary, StaticsError, Step};
use crate::abilities::{self, charts};
use crate::failure::Cause;
use pullback_manifold::system::{ChartChanges, System};

/// Cosine below which the next step is shorter.
const GENTLE_BEND: f64 = 0.9;
/// The engine of a path: all that a step needs beside the system.
pub struct PathRun {
    pub(super) newton: Newton,
    pub(super) norm: Norm,
    pub(super) options: ArcLengthOptions,
    /// Kinks of functions of the load parameter.
    pub(super) kinks: Vec<f64>,
    pub(super) at: Position,
    pub(super) next: Position,
    pub(super) ds: f64,
    phase: Phase,
    /// Whether the tangent at the present position is known.
    fresh: bool,
    /// Unstable directions at the present position.
    pub(super) unstable: Option<usize>,
    /// Changes of chart not reported yet.
    changes: usize,
    /// The equilibrium reported last.
    reached: Reached,
}

/// What comes next on a path.
enum Phase {
    /// The equilibrium under the loads at the start.
    Begin,
    /// A step.
    Advance,
    /// The events and the end of a converged step.
    Report(Converging),
    End,
}

/// A reported equilibrium.
#[derive(Default)]
struct Reached {
    /// Without its coordinates and history.
    step: Step<'static>,
    q: Vec<f64>,
    history: Vec<Iteration>,
}

impl StaticAnalysis for PathRun {
    type Options = ArcLengthOptions;

    fn new(
        system: &mut dyn System,
        q: Vec<f64>,
        options: &ArcLengthOptions,
    ) -> Result<Self, StaticsError> {
        let numbers = [
            ("first_step", options.first_step),
            ("min_step", options.min_step),
            ("max_step", options.max_step),
            ("load_scale", options.load_scale),
            ("target_iterations", options.target_iterations as f64),
        ];
        check(&numbers, &options.newton)?;
        let counts = |(event, _): &(Event, bool)| *event == Event::Bifurcation;
        if options.events.iter().any(counts) && !system.is_symmetric() {
            return Err(StaticsError::Asymmetric);
        }
        let newton = Newton::new(system, &options.newton, options.from)?;
        let q = newton.start(q)?;
        let n = q.len();
        let mut events = options.events.iter().map(|(event, _)| *event);
        if let Some(event) = events.find(|event| !event.can_occur(n)) {
            return Err(StaticsError::Event(event));
        }
        let weights = newton.inverse_scale.iter().map(|s| s * s / n as f64);
        let norm = Norm {
            weights: weights.collect(),
            load: 1.0 / (options.load_scale * options.load_scale),
        };
        let at = Position {
            q,
            t: options.from,
            tangent: PathDirection {
                dq: vec![0.0; n],
                dt: if options.forward { 1.0 } else { -1.0 },
            },
        };
        Ok(Self {
            newton,
            norm,
            next: at.clone(),
            at,
            kinks: abilities::events(system).kinks(),
            ds: options.first_step.min(options.max_step),
            phase: Phase::Begin,
            fresh: false,
            unstable: None,
            changes: 0,
            reached: Reached::default(),
            options: options.clone(),
        })
    }

    /// Goes on to the next equilibrium or event.
    fn next(&mut self, system: &mut dyn System) -> Result<bool, StaticsError> {
        loop {
            match std::mem::replace(&mut self.phase, Phase::Advance) {
                Phase::Begin => {
                    let (_, start) = begin(&mut self.newton, system, &mut self.at.q)?;
                    self.newton.held_coordinates.clear();
                    let history = self.newton.history.clone();
                    self.reach(start, history);
                    return Ok(true);
                }
                Phase::Advance if self.newton.summary.steps >= self.options.max_steps => {
                    self.phase = Phase::End;
                }
                Phase::Advance => self.advance(system)?,
                Phase::Report(mut converging) => {
                    match converging.located.next() {
                        Some(found) => self.report_event(system, found, converging)?,
                        None => self.accept(system, converging),
                    }
                    return Ok(true);
                }
                Phase::End => {
                    self.phase = Phase::End;
                    return Ok(false);
                }
            }
        }
    }

    fn report(&self) -> Step<'_> {
        Step {
            q: &self.reached.q,
            residuals: &self.reached.history,
            ..self.reached.step
        }
    }

    /// The coordinates of the last event if the run ended there, of the last step otherwise.
    fn q(&self) -> &[f64] {
        match self.reached.step.event {
            Some(_) => &self.reached.q,
            None => &self.at.q,
        }
    }

    fn summary(&self) -> &StaticSummary {
        &self.newton.summary
    }
}

impl PathRun {
    /// The present position is an equilibrium to report.
    fn reach(&mut self, step: Step<'static>, history: Vec<Iteration>) {
        self.reached = Reached {
            step,
            q: self.at.q.clone(),
            history,
        };
    }

    /// One attempt at a step; a failed one is halved.
    fn advance(&mut self, system: &mut dyn System) -> Result<(), StaticsError> {
        self.newton.history.clear();
        let ready = if self.fresh {
            Ok(())
        } else {
            self.find_tangent(system)
        };
        // A smaller step would begin with the same tangent.
        let hopeless = ready.is_err();
        let (ds, kink) = self.goal();
        let outcome = ready.and_then(|()| self.attempt(system, ds, kink));
        match outcome {
            Ok(step) => {
                let summary = &mut self.newton.summary;
                summary.steps += 1;
                summary.chart_changes += self.changes;
                self.phase = Phase::Report(step);
                Ok(())
            }
            Err(failure) => self.halve(system, failure, ds, hopeless),
        }
    }

    /// Changes charts, and finds the tangent at the present position.
    fn find_tangent(&mut self, system: &mut dyn System) -> Result<(), Cause> {
        let at = &mut self.at;
        // Functions of t are those from the right, and a path may leave a kink to the left.
        if at.tangent.dt < 0.0 && self.kinks.contains(&at.t) {
            at.t = at.t.next_down();
        }
        let changed = charts(system).change_charts(at.t, &mut at.q, &mut at.tangent.dq, &mut []);
        self.changes += changed.charts;
        (self.newton.tangent(system, at, &self.norm)).map_err(off_path)?;
        self.unstable = self.newton.unstable(system);
        Ok(())
    }

    /// Halves the step after a failure, or ends the path.
    fn halve(
        &mut self,
        system: &mut dyn System,
        failure: Cause,
        ds: f64,
        hopeless: bool,
    ) -> Result<(), StaticsError> {
        self.newton.summary.rejected += 1;
        let to = self.at.t + ds * self.at.tangent.dt;
        let mut failed = self.newton.fail(system, failure, to);
        let here = [self.at.t, self.at.t.next_up()];
        let here = self.kinks.iter().find(|kink| here.contains(kink));
        failed.kink = failed.kink.or(here.copied());
        self.ds = 0.5 * ds;
        if self.ds < self.options.min_step || hopeless {
            // Leaves the system at the last equilibrium.
            (self.newton.evaluate(system, None, &self.at.q, self.at.t)).ok();
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
        let spent = if last {
            step.unreported
        } else {
            found.iterations
        };
        step.unreported -= spent;
        let Position { mut q, t, .. } = found.position.clone();
        let newton = &mut self.newton;
        newton.evaluate(system, None, &q, t).map_err(|source| {
            let failure = Cause::System(source);
            StaticsError::Step(newton.fail(system, failure, t))
        })?;
        if last && matches!(self.options.events[found.index].0, Event::Load(_)) {
            let changed = settle(newton, system, &mut q, &mut [], t);
            newton.summary.chart_changes += changed.charts;
            self.changes += changed.charts;
        }
        let summary = &mut newton.summary;
        summary.iterations += spent;
        (summary.t, summary.finished) = (t, last);
        self.reached = Reached {
            step: Step {
                number: summary.steps,
                t,
                step_size: found.s,
                iterations: spent,
                chart_changes: self.changes,
                event: Some(found.index),
                unstable: found.unstable,
                ..Step::default()
            },
            q,
            history: found.history,
        };
        self.phase = match (last, found.branch, found.directions) {
            (true, ..) => Phase::End,
            (false, _, directions @ 2..) if self.options.switch_branch => {
                return Err(StaticsError::Multiple { t, directions });
            }
            (false, Some(branch), _) if self.options.switch_branch => {
                self.switch(found.position, branch);
                Phase::Advance
            }
            (false, ..) => Phase::Report(step),
        };
        Ok(())
    }

    /// Goes on from a bifurcation along the path that crosses the present one.
    fn switch(&mut self, position: Position, mut branch: PathDirection) {
        let sense = self.norm.sense(&branch);
        branch.dq.iter_mut().for_each(|x| *x *= sense);
        branch.dt *= sense;
        self.at = Position {
            tangent: branch,
            ..position
        };
        // The last step may have been halved many times to end near this point.
        self.ds = self.options.first_step.min(self.options.max_step);
        self.fresh = true;
        self.unstable = None;
        self.options.switch_branch = false;
    }

    /// Accepts and reports the end of a converged step, and chooses the size of the next one.
    fn accept(&mut self, system: &mut dyn System, step: Converging) {
        std::mem::swap(&mut self.at, &mut self.next);
        // Where nothing is known, the count before is the best one.
        self.unstable = step.unstable.or(self.unstable);
        let Position { q, t, tangent } = &mut self.at;
        if step.bend.is_none() {
            // Behind a kink the load goes on as before, on another tangent.
            tangent.dq.fill(0.0);
        }
        if step.moved {
            // Locating events has moved the system: restore it.
            (self.newton.evaluate(system, None, q, *t)).ok();
        }
        // The next step uses this tangent, unless charts change.
        let changed = settle(&mut self.newton, system, q, &mut tangent.dq, *t);
        let summary = &mut self.newton.summary;
        summary.iterations += step.iterations;
        summary.chart_changes += changed.charts;
        summary.t = *t;
        let end = Step {
            number: summary.steps,
            t: *t,
            step_size: step.ds,
            iterations: step.iterations,
            chart_changes: self.changes + changed.charts,
            unstable: step.unstable,
            ..Step::default()
        };
        self.changes = 0;
        self.fresh = changed == ChartChanges::default() && step.bend.is_some();
        self.reach(end, step.history);
        let (iterations, bend) = (step.iterations.max(1) as f64, step.bend);
        let ease = (self.options.target_iterations as f64 / iterations).sqrt();
        let sharp = bend.is_some_and(|bend| bend < GENTLE_BEND);
        let straightness = if sharp { 0.7 } else { 1.5 };
        self.ds = (self.ds * ease.clamp(0.5, straightness)).min(self.options.max_step);
    }
}

/// Changes charts at an equilibrium, and goes to that in the new ones if the discretisation depends on them.
fn settle(
    newton: &mut Newton,
    system: &mut dyn System,
    q: &mut [f64],
    tangent: &mut [f64],
    t: f64,
) -> ChartChanges {
    let mut changed = charts(system).change_charts(t, q, tangent, &mut []);
    if changed.residual {
        let start = q.to_vec();
        match balance(newton, system, q, t) {
            Ok(changes) => changed.charts += changes,
            Err(_) => {
                q.copy_from_slice(&start);
                charts(system).start(t, q);
            }
        }
        // A path may leave the node at which a slide rests.
        newton.held_coordinates.clear();
    }
    if changed != ChartChanges::default() {
        newton.evaluate(system, None, q, t).ok();
    }
    changed
}
