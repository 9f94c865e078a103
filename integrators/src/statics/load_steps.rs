//! Load control with automatic step size.

#![allow(non_snake_case)]

use super::error::StaticsError;
use super::newton::Newton;
use super::stability::unstable;
use super::start::begin;
use super::{Iteration, NewtonOptions, Step};
use crate::failure::Failure;
use crate::linear_solver::{AutoSolver, LinearSolver, Symmetry};
use pullback_manifold::system::{ChartChanges, System};
use std::ops::ControlFlow;

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
    pub newton: NewtonOptions,
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
            newton: NewtonOptions::default(),
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
pub struct Summary {
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

/// Follows the equilibrium of `system` from `q` over the load range, with the default solver. Loads
/// at the start are balanced first, as step 0.
///
/// # Errors
/// [`StaticsError`] with the failed step, its load, the cause and the residuals.
pub fn solve_statics<Y: System + ?Sized>(
    system: &mut Y,
    q: &mut Vec<f64>,
    options: &StaticOptions,
    observer: &mut dyn FnMut(&mut Y, &Step<'_>) -> ControlFlow<()>,
) -> Result<Summary, StaticsError> {
    solve_statics_with(&mut AutoSolver::new(), system, q, options, observer)
}

/// The equilibrium of `system` at the end of the load range, from zero coordinates.
///
/// # Errors
/// As [`solve_statics`].
pub fn equilibrium<Y: System + ?Sized>(
    system: &mut Y,
    options: &StaticOptions,
) -> Result<Vec<f64>, StaticsError> {
    let mut q = Vec::new();
    solve_statics(system, &mut q, options, &mut |_, _| {
        ControlFlow::Continue(())
    })?;
    Ok(q)
}

/// As [`solve_statics`], with another linear solver.
///
/// # Errors
/// As [`solve_statics`].
pub fn solve_statics_with<Y: System + ?Sized>(
    solver: &mut dyn LinearSolver,
    system: &mut Y,
    q: &mut Vec<f64>,
    options: &StaticOptions,
    observer: &mut dyn FnMut(&mut Y, &Step<'_>) -> ControlFlow<()>,
) -> Result<Summary, StaticsError> {
    check(options)?;
    q.resize(system.pattern().dim(), 0.0);
    analyse(solver, system)?;
    let mut newton = Newton::new(system, &options.newton);
    let mut summary = Summary {
        t: options.from,
        ..Summary::default()
    };
    let direction = (options.to - options.from).signum();
    let mut dt = direction * options.first_step.abs().min(options.max_step.abs());
    let mut start = q.clone();
    let beginning = begin(&mut newton, solver, system, q, &mut summary, observer)?;
    if beginning.flow.is_break() {
        return Ok(summary);
    }
    let mut known = beginning.known;
    loop {
        let rest = options.to - summary.t;
        // The last step absorbs a tiny remainder.
        let last = rest.abs() <= dt.abs() * (1.0 + 1e-9);
        let t = if last { options.to } else { summary.t + dt };
        start.copy_from_slice(q);
        newton.history.clear();
        let predicted = predict(&mut newton, solver, system, q, [summary.t, t], known);
        // A smaller step would begin with the same tangent, unless this one was extrapolated.
        let exact = known != Known::Evaluated || summary.steps == 0;
        let hopeless = exact && matches!(predicted, Err(Failure::Linear(_)));
        let outcome = predicted
            .and_then(|()| {
                let previous = Some((summary.t, start.as_slice()));
                correct(&mut newton, solver, system, q, t, previous)
            })
            .and_then(|()| settle(&mut newton, solver, system, q, t));
        summary.evaluations = newton.evaluations;
        summary.factorisations = newton.factorisations;
        match outcome {
            Ok(chart_changes) => {
                let iterations = newton.iterations();
                summary.steps += 1;
                summary.iterations += iterations;
                summary.chart_changes += chart_changes;
                let step_size = t - summary.t;
                summary.t = t;
                // The next step begins with this factorisation, made at the iterate before the
                // last. A singular tangent fails the next step, if any.
                known = Known::Evaluated;
                let mut stability = None;
                if system.is_symmetric() && newton.factorise(solver).is_ok() {
                    known = Known::Factorised;
                    stability = unstable(&newton, solver, system);
                }
                summary.factorisations = newton.factorisations;
                let report = Step {
                    number: summary.steps,
                    t,
                    step_size,
                    q,
                    iterations,
                    residuals: &newton.history,
                    chart_changes,
                    event: None,
                    unstable: stability,
                };
                let flow = observer(system, &report);
                if last {
                    summary.finished = true;
                    return Ok(summary);
                }
                if flow.is_break() {
                    return Ok(summary);
                }
                if iterations <= options.easy {
                    dt = direction * (2.0 * dt.abs()).min(options.max_step.abs());
                }
            }
            Err(failure) => {
                summary.rejected += 1;
                known = Known::Nothing;
                let mut failed = newton.fail(system, failure, &summary, t);
                q.copy_from_slice(&start);
                system.start(summary.t, q);
                system.change_charts(summary.t, q, &mut [], &mut []);
                dt = 0.5 * (t - summary.t);
                if hopeless {
                    return Err(StaticsError::Step(failed));
                }
                if dt.abs() < options.min_step.abs() || dt == 0.0 {
                    failed.min_step = Some(options.min_step);
                    return Err(StaticsError::Step(failed));
                }
            }
        }
    }
}

/// State of the tangent at the beginning of a step.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Known {
    Nothing,
    Evaluated,
    Factorised,
}

/// The first correction, with the tangent at the old load.
fn predict<Y: System + ?Sized>(
    newton: &mut Newton,
    solver: &mut dyn LinearSolver,
    system: &mut Y,
    q: &mut [f64],
    [from, to]: [f64; 2],
    known: Known,
) -> Result<(), Failure> {
    if known == Known::Nothing {
        newton
            .evaluate(system, None, q, from)
            .map_err(Failure::System)?;
    }
    if known != Known::Factorised {
        newton.factorise(solver)?;
    }
    // δq = K⁻¹ (r + r_λ Δλ): with r_λ a prescribed support bends the whole structure, while the
    // residual alone would first strain the element next to it.
    for ((dq, r), rate) in newton.dq.iter_mut().zip(&newton.r).zip(&newton.r_lambda) {
        *dq = r + rate * (to - from);
    }
    let residual = newton.largest(system, &newton.dq);
    solver
        .solve(Some(&newton.S), &mut newton.dq)
        .map_err(Failure::Linear)?;
    for (q, dq) in q.iter_mut().zip(&newton.dq) {
        *q += dq;
    }
    newton.history.push(Iteration {
        residual,
        ratio: f64::INFINITY,
        correction: newton.size(&newton.dq),
        damping: 1.0,
    });
    Ok(())
}

fn correct<Y: System + ?Sized>(
    newton: &mut Newton,
    solver: &mut dyn LinearSolver,
    system: &mut Y,
    q: &mut [f64],
    t: f64,
    previous: Option<(f64, &[f64])>,
) -> Result<(), Failure> {
    let mut lambda = t;
    newton.correct(system, solver, q, &mut lambda, None, previous)
}

/// Changes charts if needed, and restores equilibrium if the discretisation of an element depends
/// on them, so that results do not depend on the path.
pub(super) fn settle<Y: System + ?Sized>(
    newton: &mut Newton,
    solver: &mut dyn LinearSolver,
    system: &mut Y,
    q: &mut [f64],
    t: f64,
) -> Result<usize, Failure> {
    let mut changes = 0;
    // If equilibrium moves an element back over its border, the second round is the last.
    for _ in 0..2 {
        let changed = system.change_charts(t, q, &mut [], &mut []);
        changes += changed.charts;
        if changed == ChartChanges::default() {
            break;
        }
        correct(newton, solver, system, q, t, None)?;
    }
    Ok(changes)
}

pub(super) fn analyse<Y: System + ?Sized>(
    solver: &mut dyn LinearSolver,
    system: &Y,
) -> Result<(), StaticsError> {
    let symmetry = if system.is_symmetric() {
        Symmetry::Symmetric
    } else {
        Symmetry::General
    };
    solver
        .analyse(system.pattern(), symmetry)
        .map_err(|source| StaticsError::Analysis { source })
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
