//! A run in time: steps that end at kinks, are halved when they fail, and are accounted for.

#![allow(non_snake_case)]

use super::initial::{accelerate, strike};
use super::step::Stepper;
use super::{
    DynamicsError, EnergyBalance, NewtonOptions, Progress, Scheme, State, StepReport, Summary,
};
use crate::failure::{Along, FailedStep, Failure, Spent, Wreck};
use crate::linear_solver::{AutoSolver, LinearSolver, Symmetry};
use pullback_manifold::system::{Energies, Point, System};
use std::ops::ControlFlow;

/// Until when, in what steps, by which scheme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DynamicOptions {
    /// Time at the end.
    pub to: f64,
    /// Step size. Between kinks steps are equal and at most this large.
    pub step: f64,
    /// A failed step is halved until it is smaller than this; then the run has failed.
    pub min_step: f64,
    /// A halved step is doubled again after this many steps in a row that converged.
    pub easy: usize,
    /// The scheme.
    pub scheme: Scheme,
    /// Newton's method inside a step.
    pub newton: NewtonOptions,
    /// Step sizes by an estimate of the local error instead of equal ones.
    pub adaptivity: Option<Adaptivity>,
    /// Whether energies are evaluated after each step, where the system knows them.
    pub energies: bool,
}

impl DynamicOptions {
    /// Equal steps of size `step` until `to` by the trapezoidal rule.
    pub fn new(to: f64, step: f64) -> Self {
        Self {
            to,
            step,
            min_step: 1e-6 * step,
            easy: 4,
            scheme: Scheme::default(),
            newton: NewtonOptions::default(),
            adaptivity: None,
            energies: true,
        }
    }
}

/// Step sizes by the local error estimate of Zienkiewicz & Xie (1991).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptivity {
    /// Local error of a step allowed, relative to the scales of the coordinates (the size of the
    /// model, one radian).
    pub tolerance: f64,
    /// Largest step.
    pub max_step: f64,
}

/// Integrates the equations of motion from where `progress` stands, with the default solver.
///
/// The observer is called after each accepted step and may stop the run.
///
/// # Errors
/// [`DynamicsError`]; `progress` is then at the last accepted step.
pub fn integrate<Y: System + ?Sized>(
    system: &mut Y,
    progress: &mut Progress,
    options: &DynamicOptions,
    observer: &mut dyn FnMut(&mut Y, &StepReport<'_>) -> ControlFlow<()>,
) -> Result<(), DynamicsError> {
    integrate_with(&mut AutoSolver::new(), system, progress, options, observer)
}

/// As [`integrate`], with a linear solver of the caller's choice.
///
/// # Errors
/// As [`integrate`].
pub fn integrate_with<Y: System + ?Sized>(
    solver: &mut dyn LinearSolver,
    system: &mut Y,
    progress: &mut Progress,
    options: &DynamicOptions,
    observer: &mut dyn FnMut(&mut Y, &StepReport<'_>) -> ControlFlow<()>,
) -> Result<(), DynamicsError> {
    check(options, progress, system)?;
    // Gyroscopic and centrifugal tangents are not symmetric whatever the stiffness is.
    solver
        .analyse(system.pattern(), Symmetry::General)
        .map_err(|source| DynamicsError::Analysis { source })?;
    let mut run = Run {
        stepper: Stepper::new(system, &options.newton),
        stops: stops(system, progress.state.t, options.to),
        options,
    };
    run.begin(system, solver, progress)?;
    while progress.state.t < options.to {
        let h = run.attempt(system, solver, progress)?;
        let Some(step_size) = h else { continue };
        let chart_changes = run.accept(system, solver, progress, step_size)?;
        let iterations = run.stepper.iterations();
        progress.summary.iterations += iterations;
        progress.summary.finished = progress.state.t >= options.to;
        let report = StepReport {
            progress,
            step_size,
            iterations,
            residuals: &run.stepper.history,
            chart_changes,
        };
        if observer(system, &report).is_break() {
            return Ok(());
        }
    }
    progress.summary.finished = true;
    Ok(())
}

struct Run<'a> {
    stepper: Stepper,
    /// Times at which a step must end, ascending; the last one is the end.
    stops: Vec<f64>,
    options: &'a DynamicOptions,
}

impl Run<'_> {
    /// Charts, accelerations and energies before the first step.
    fn begin<Y: System + ?Sized>(
        &mut self,
        system: &mut Y,
        solver: &mut dyn LinearSolver,
        progress: &mut Progress,
    ) -> Result<(), DynamicsError> {
        let fresh = progress.state.a.is_empty();
        // A run that is continued may have been given another step.
        let DynamicOptions { step, min_step, .. } = *self.options;
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
        // A system that has not seen this state yet chooses its charts; a state that was accepted
        // before stays as it is.
        let mut none: [&mut [f64]; 0] = [];
        let mut both: [&mut [f64]; 2] = [a, algorithmic];
        let vectors: &mut [&mut [f64]] = if fresh { &mut none } else { &mut both };
        let changed = system.change_charts(*t, q, v, vectors).charts;
        if fresh {
            progress.summary.chart_changes += changed;
            self.accelerate(system, solver, progress)?;
            progress.summary.energy = None;
            if let Some(now) = self.energies(system, &progress.state, progress.state.t)? {
                progress.summary.energy = Some(EnergyBalance {
                    start: now.kinetic + now.stored,
                    now,
                    ..EnergyBalance::default()
                });
            }
        }
        Ok(())
    }

    fn accelerate<Y: System + ?Sized>(
        &mut self,
        system: &mut Y,
        solver: &mut dyn LinearSolver,
        progress: &mut Progress,
    ) -> Result<(), DynamicsError> {
        let Stepper { r, S, .. } = &mut self.stepper;
        progress.summary.evaluations += 1;
        progress.summary.factorisations += 1;
        let h = self.options.step.min(progress.next_step);
        accelerate(system, solver, &mut progress.state, h, [r, S])
    }

    fn energies<Y: System + ?Sized>(
        &self,
        system: &mut Y,
        state: &State,
        t: f64,
    ) -> Result<Option<Energies>, DynamicsError> {
        if !self.options.energies {
            return Ok(None);
        }
        let at = Point {
            t,
            q: &state.q,
            v: &state.v,
            a: &state.a,
        };
        system
            .energies(at)
            .map_err(|source| DynamicsError::System { t, source })
    }

    /// One attempt at a step; its size when it may be accepted, `None` when a smaller one is due.
    fn attempt<Y: System + ?Sized>(
        &mut self,
        system: &mut Y,
        solver: &mut dyn LinearSolver,
        progress: &mut Progress,
    ) -> Result<Option<f64>, DynamicsError> {
        let from = progress.state.t;
        let stop = self.stops.iter().copied().find(|&s| s > from);
        let stop = stop.unwrap_or(self.options.to);
        // Equal steps to the next stop, none of them a tiny remainder.
        let count = ((stop - from) / progress.next_step - 1e-6).ceil().max(1.0);
        let h = (stop - from) / count;
        // A step ends before a kink: functions of time are asked on its left.
        let to = if count > 1.0 {
            from + h
        } else {
            stop.next_down()
        };
        rebase(progress, h);
        let before = (self.stepper.evaluations, self.stepper.factorisations);
        let scheme = &self.options.scheme;
        let outcome = self
            .stepper
            .step(system, solver, scheme, &progress.state, to);
        progress.summary.evaluations += self.stepper.evaluations - before.0;
        progress.summary.factorisations += self.stepper.factorisations - before.1;
        if let Err(failure) = outcome {
            progress.summary.failed += 1;
            return self.halve(system, progress, failure, [from, to]);
        }
        if count <= 1.0 {
            self.stepper.next.t = stop;
        }
        let Some(adaptivity) = self.options.adaptivity else {
            return Ok(Some(h));
        };
        let error = self.local_error(system, &progress.state, h);
        let factor = (0.9 * (adaptivity.tolerance / error).cbrt()).clamp(0.3, 2.0);
        // A step forced short by a stop says nothing about the size of the next one.
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
            return self.halve(system, progress, Failure::Diverged, [from, to]);
        }
        progress.next_step = wanted;
        Ok(None)
    }

    /// After a failure: half the step, or the end.
    fn halve<Y: System + ?Sized>(
        &mut self,
        system: &mut Y,
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
        let wreck = Wreck {
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
        let spent = Spent {
            evaluations,
            factorisations,
        };
        let step = FailedStep::new(system, wreck, Along::Time, span, steps, rejected, spent);
        Err(DynamicsError::Step(Box::new(step)))
    }

    /// Takes the new state, its charts, and accelerations anew where a kink makes them jump.
    fn accept<Y: System + ?Sized>(
        &mut self,
        system: &mut Y,
        solver: &mut dyn LinearSolver,
        progress: &mut Progress,
        h: f64,
    ) -> Result<usize, DynamicsError> {
        let before_kink = self.stepper.next.t;
        let at_stop = self.stops.contains(&before_kink) && before_kink < self.options.to;
        std::mem::swap(&mut progress.state, &mut self.stepper.next);
        progress.last_step = h;
        progress.summary.steps += 1;
        let asked = if at_stop {
            before_kink.next_down()
        } else {
            before_kink
        };
        let left = self.energies(system, &progress.state, asked)?;
        if let (Some(now), Some(balance)) = (left, &mut progress.summary.energy) {
            let power = |e: &Energies| e.supplied - e.dissipated;
            balance.work += 0.5 * h * (power(&balance.now) + power(&now));
            balance.now = now;
            balance.largest_defect = balance.largest_defect.max(balance.defect().abs());
        }
        let State {
            t,
            q,
            v,
            a,
            algorithmic,
        } = &mut progress.state;
        let changes = system.change_charts(*t, q, v, &mut [a, algorithmic]);
        progress.summary.chart_changes += changes.charts;
        if at_stop {
            let Stepper { r, S, .. } = &mut self.stepper;
            if strike(system, solver, &mut progress.state, h, [r, S])? {
                progress.summary.evaluations += 1;
                progress.summary.factorisations += 1;
            }
            self.accelerate(system, solver, progress)?;
            let right = self.energies(system, &progress.state, progress.state.t)?;
            if let (Some(now), Some(balance)) = (right, &mut progress.summary.energy) {
                // What a jump of a driven velocity gives, its support gives at once.
                let energy = |e: &Energies| e.kinetic + e.stored;
                balance.work += energy(&now) - energy(&balance.now);
                balance.now = now;
            }
        }
        if self.options.adaptivity.is_none() {
            progress.easy += 1;
            let nominal = self.options.step;
            if progress.easy >= self.options.easy && progress.next_step < nominal {
                progress.next_step = nominal.min(2.0 * progress.next_step);
                progress.easy = 0;
            }
        }
        Ok(changes.charts)
    }

    /// Largest local error of the coordinates over their scales (Zienkiewicz & Xie 1991).
    fn local_error<Y: System + ?Sized>(&self, system: &Y, state: &State, h: f64) -> f64 {
        let factor = self.options.scheme.error_factor() * h * h;
        let scales = system.scales().coordinate;
        let new = &self.stepper.next.algorithmic;
        let change = state.algorithmic.iter().zip(new).enumerate();
        let sizes = change
            .map(|(i, (old, new))| factor * (new - old).abs() / scales[system.kind(i).index()]);
        sizes.fold(f64::MIN_POSITIVE, f64::max)
    }
}

/// The algorithmic acceleration belongs to the time tₙ + (α_m − α_f) h: with another step size it
/// moves along.
fn rebase(progress: &mut Progress, h: f64) {
    let ratio = h / progress.last_step;
    if progress.last_step > 0.0 && (ratio - 1.0).abs() > 1e-9 {
        let State { a, algorithmic, .. } = &mut progress.state;
        for (old, a) in algorithmic.iter_mut().zip(a) {
            *old = *a + (*old - *a) * ratio;
        }
        progress.last_step = h;
    }
}

/// Kinks between the start and the end, and the end.
fn stops<Y: System + ?Sized>(system: &Y, from: f64, to: f64) -> Vec<f64> {
    let slack = 1e-9 * (to - from);
    let mut stops = system.kinks();
    stops.retain(|&t| t > from + slack && t < to - slack);
    stops.push(to);
    stops.sort_by(f64::total_cmp);
    stops.dedup_by(|b, a| *b - *a <= slack);
    stops
}

fn check<Y: System + ?Sized>(
    options: &DynamicOptions,
    progress: &Progress,
    system: &Y,
) -> Result<(), DynamicsError> {
    let positive = "it must be positive and finite";
    let mut sizes = vec![("step", options.step), ("min_step", options.min_step)];
    if let Some(Adaptivity {
        tolerance,
        max_step,
    }) = options.adaptivity
    {
        sizes.extend([("tolerance", tolerance), ("max_step", max_step)]);
    }
    for (name, value) in sizes {
        if !(value > 0.0 && value.is_finite()) {
            return Err(DynamicsError::Option {
                name,
                value,
                wanted: positive,
            });
        }
    }
    if !(options.to >= progress.state.t && options.to.is_finite()) {
        return Err(DynamicsError::Option {
            name: "to",
            value: options.to,
            wanted: "it must be finite and not before the time of the state",
        });
    }
    let n = system.pattern().dim();
    for (what, x) in [
        ("coordinates", &progress.state.q),
        ("velocities", &progress.state.v),
    ] {
        if x.len() != n {
            return Err(DynamicsError::Initial {
                what,
                problem: format!("{} given where the system has {n} coordinates", x.len()),
            });
        }
    }
    Ok(())
}
