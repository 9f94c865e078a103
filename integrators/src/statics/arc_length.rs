//! Path following: pseudo-arc-length continuation (Riks 1979; Keller 1977) with located events.
//!
//! The path (q, λ)(s) is followed with unit tangents in the norm ‖(q, λ)‖² = Σ (qᵢ/scaleᵢ)²/n +
//! (λ/λ_scale)², which is independent of mesh and units. Each step solves on the hyperplane normal
//! to the tangent at its start; limit points in λ are passed, and located afterwards if requested.

#![allow(non_snake_case)]

use super::error::StaticsError;
use super::load_steps::analyse;
use super::locate::{Located, locate};
use super::newton::{Condition, Newton};
use super::path::{ArcLengthOptions, PathSummary};
use super::stability::unstable;
use super::start::begin;
use super::{Iteration, Step};
use crate::failure::Failure;
use crate::linear_solver::{AutoSolver, LinearSolver};
use pullback_manifold::system::{ChartChanges, System};
use std::ops::ControlFlow;

/// Follows the equilibrium path of `system` from `q`, with the default solver. Loads at the start
/// are balanced first, as step 0.
///
/// # Errors
/// [`StaticsError`] with the failed step, its load, the cause and the residuals.
pub fn trace_path<Y: System + ?Sized>(
    system: &mut Y,
    q: &mut Vec<f64>,
    options: &ArcLengthOptions,
    observer: &mut dyn FnMut(&mut Y, &Step<'_>) -> ControlFlow<()>,
) -> Result<PathSummary, StaticsError> {
    trace_path_with(&mut AutoSolver::new(), system, q, options, observer)
}

/// Position on the path with its unit tangent.
#[derive(Clone)]
pub(super) struct Position {
    pub q: Vec<f64>,
    pub lambda: f64,
    /// dq/ds and dλ/ds.
    pub dq: Vec<f64>,
    pub d_lambda: f64,
}

/// The norm of the arc length.
pub(super) struct Norm {
    /// Weight of each coordinate, 1/(n scale²).
    weights: Vec<f64>,
    /// Weight of the load, 1/load_scale².
    load: f64,
}

impl Norm {
    pub fn dot(&self, a: (&[f64], f64), b: (&[f64], f64)) -> f64 {
        let q: f64 = (a.0.iter().zip(b.0).zip(&self.weights))
            .map(|((a, b), w)| a * b * w)
            .sum();
        q + a.1 * b.1 * self.load
    }

    /// Whether a step was corrected by more than its own length, or its displacements by more than
    /// theirs: its end may lie on another part of the path. If displacements are small beside the
    /// size of the structure, a step is almost a load step.
    fn strays(&self, from: &Position, to: &Position, ds: f64) -> bool {
        let (mut corrected, mut predicted) = (0.0, 0.0);
        let ends = to.q.iter().zip(&from.q).zip(&from.dq);
        for (((to, from), dq), w) in ends.zip(&self.weights) {
            let ahead = ds * dq;
            corrected += w * (to - from - ahead).powi(2);
            predicted += w * ahead.powi(2);
        }
        let load = (to.lambda - from.lambda - ds * from.d_lambda).powi(2) * self.load;
        corrected + load > ds * ds || corrected > predicted + LEAST * LEAST
    }
}

/// As [`trace_path`], with another linear solver.
///
/// # Errors
/// As [`trace_path`].
pub fn trace_path_with<Y: System + ?Sized>(
    solver: &mut dyn LinearSolver,
    system: &mut Y,
    q: &mut Vec<f64>,
    options: &ArcLengthOptions,
    observer: &mut dyn FnMut(&mut Y, &Step<'_>) -> ControlFlow<()>,
) -> Result<PathSummary, StaticsError> {
    check(options)?;
    let n = system.pattern().dim();
    q.resize(n, 0.0);
    analyse(solver, system)?;
    let mut newton = Newton::new(system, &options.newton);
    let norm = Norm {
        weights: newton
            .inverse_scale
            .iter()
            .map(|s| s * s / n as f64)
            .collect(),
        load: 1.0 / (options.load_scale * options.load_scale),
    };
    let mut out = PathSummary::default();
    let mut at = Position {
        q: q.clone(),
        lambda: options.from,
        dq: vec![0.0; n],
        d_lambda: if options.forward { 1.0 } else { -1.0 },
    };
    out.summary.t = at.lambda;
    let beginning = begin(
        &mut newton,
        solver,
        system,
        &mut at.q,
        &mut out.summary,
        observer,
    )?;
    if beginning.flow.is_break() {
        q.copy_from_slice(&at.q);
        return Ok(out);
    }
    let mut ds = options.first_step;
    let mut next = at.clone();
    let mut fresh = false;
    // Changes of chart not reported yet.
    let mut changes = 0;
    while out.summary.steps < options.max_steps {
        newton.history.clear();
        let mut outcome = Ok(());
        let mut hopeless = false;
        if !fresh {
            let changed = system.change_charts(at.lambda, &mut at.q, &mut at.dq, &mut []);
            changes += changed.charts;
            outcome = tangent(&mut newton, solver, system, &mut at, &norm);
            // A smaller step would begin with the same tangent.
            hopeless = outcome.is_err();
        }
        if outcome.is_ok() {
            outcome = advance(&mut newton, solver, system, &at, ds, &norm, &mut next);
        }
        let iterations = newton.iterations();
        let history = newton.history.clone();
        if outcome.is_ok() {
            next.dq.copy_from_slice(&at.dq);
            next.d_lambda = at.d_lambda;
            outcome = tangent(&mut newton, solver, system, &mut next, &norm);
        }
        let bend = norm.dot((&at.dq, at.d_lambda), (&next.dq, next.d_lambda));
        outcome = match outcome {
            // The last step must also arrive from its other end.
            Ok(())
                if bend < SHARPEST_BEND
                    || norm.strays(&at, &next, ds)
                    || norm.strays(&next, &at, -ds) =>
            {
                Err(Failure::OffPath)
            }
            Err(Failure::Diverged) => Err(Failure::OffPath),
            outcome => outcome,
        };
        let mut stability = None;
        let mut located = Vec::new();
        if outcome.is_ok() {
            stability = unstable(&newton, solver, system);
            let step = (&at, &next, ds);
            outcome = locate(&mut newton, solver, system, step, &norm, options)
                .map(|found| located = found);
        }
        out.summary.evaluations = newton.evaluations;
        out.summary.factorisations = newton.factorisations;
        if let Err(failure) = outcome {
            out.summary.rejected += 1;
            fresh = false;
            let to = at.lambda + ds * at.d_lambda;
            let mut failed = newton.fail(system, failure, &out.summary, to);
            ds *= 0.5;
            if ds < options.min_step || hopeless {
                failed.min_step = (!hopeless).then_some(options.min_step);
                q.copy_from_slice(&at.q);
                return Err(StaticsError::Step(failed));
            }
            continue;
        }
        out.summary.steps += 1;
        out.summary.chart_changes += changes;
        let moved = !located.is_empty();
        // Counts that the last row reports besides its own.
        let mut untold: usize = iterations + located.iter().map(|l| l.iterations).sum::<usize>();
        for found in located {
            let Located {
                index, position, ..
            } = &found;
            let last = options.events[*index].1;
            let spent = if last { untold } else { found.iterations };
            untold -= spent;
            out.summary.iterations += spent;
            out.events.push((*index, position.lambda));
            newton
                .evaluate(system, None, &position.q, position.lambda)
                .map_err(|source| {
                    let failure = Failure::System(source);
                    StaticsError::Step(newton.fail(system, failure, &out.summary, position.lambda))
                })?;
            let report = Step {
                number: out.summary.steps,
                t: position.lambda,
                step_size: found.s,
                q: &position.q,
                iterations: spent,
                residuals: &found.history,
                chart_changes: changes,
                event: Some(*index),
                unstable: found.unstable,
            };
            let flow = observer(system, &report);
            if last || flow.is_break() {
                q.copy_from_slice(&position.q);
                out.summary.t = position.lambda;
                out.summary.finished = last;
                return Ok(out);
            }
        }
        out.summary.iterations += iterations;
        std::mem::swap(&mut at, &mut next);
        out.summary.t = at.lambda;
        if moved {
            // Locating events has moved the system: restore it.
            newton.evaluate(system, None, &at.q, at.lambda).ok();
        }
        let report = Step {
            number: out.summary.steps,
            t: at.lambda,
            step_size: ds,
            q: &at.q,
            iterations,
            residuals: &history,
            chart_changes: changes,
            event: None,
            unstable: stability,
        };
        if observer(system, &report).is_break() {
            break;
        }
        // The next step uses this tangent, unless charts change.
        let changed = system.change_charts(at.lambda, &mut at.q, &mut at.dq, &mut []);
        changes = changed.charts;
        fresh = changed == ChartChanges::default();
        let ease = (options.target_iterations as f64 / iterations.max(1) as f64).sqrt();
        let straightness = if bend < GENTLE_BEND { 0.7 } else { 1.5 };
        ds = (ds * ease.clamp(0.5, straightness)).min(options.max_step);
    }
    q.copy_from_slice(&at.q);
    Ok(out)
}

/// Cosine between successive tangents below which a step is rejected: a path that turns by more
/// within one step may be another one.
pub(super) const SHARPEST_BEND: f64 = 0.6;
/// Corrections of coordinates over their scales that cannot be another part of the path.
const LEAST: f64 = 1e-12;
/// Cosine below which the next step is shorter.
const GENTLE_BEND: f64 = 0.9;

/// Unit tangent at a position, in the direction of its present one.
pub(super) fn tangent<Y: System + ?Sized>(
    newton: &mut Newton,
    solver: &mut dyn LinearSolver,
    system: &mut Y,
    at: &mut Position,
    norm: &Norm,
) -> Result<(), Failure> {
    newton
        .evaluate(system, None, &at.q, at.lambda)
        .map_err(Failure::System)?;
    newton.factorise(solver)?;
    newton.solve_rate(solver)?;
    let rate = (newton.q_lambda.as_slice(), 1.0);
    let length = norm.dot(rate, rate).sqrt();
    let sense = norm.dot(rate, (&at.dq, at.d_lambda)).signum() / length;
    if !sense.is_finite() {
        return Err(Failure::Diverged);
    }
    for (dq, rate) in at.dq.iter_mut().zip(rate.0) {
        *dq = sense * rate;
    }
    at.d_lambda = sense;
    Ok(())
}

/// Predicts along the tangent and corrects on the hyperplane normal to it.
#[allow(clippy::too_many_arguments, reason = "a private step of one algorithm")]
pub(super) fn advance<Y: System + ?Sized>(
    newton: &mut Newton,
    solver: &mut dyn LinearSolver,
    system: &mut Y,
    at: &Position,
    ds: f64,
    norm: &Norm,
    next: &mut Position,
) -> Result<(), Failure> {
    for (q, (q0, dq)) in next.q.iter_mut().zip(at.q.iter().zip(&at.dq)) {
        *q = q0 + ds * dq;
    }
    next.lambda = at.lambda + ds * at.d_lambda;
    newton.history.clear();
    let loads = newton.largest(system, &newton.r_lambda);
    newton.history.push(Iteration {
        residual: loads.map(|r| r * (ds * at.d_lambda).abs()),
        ratio: f64::INFINITY,
        correction: ds.abs() * newton.size(&at.dq),
        damping: 1.0,
    });
    let c: Vec<f64> = (at.dq.iter().zip(&norm.weights))
        .map(|(dq, w)| dq * w)
        .collect();
    let condition = Condition {
        c: &c,
        c_lambda: at.d_lambda * norm.load,
        q0: &at.q,
        lambda0: at.lambda,
        ds,
    };
    newton.correct(
        system,
        solver,
        &mut next.q,
        &mut next.lambda,
        Some(&condition),
        Some((at.lambda, &at.q)),
    )
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
