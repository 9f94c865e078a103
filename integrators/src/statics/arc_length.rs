//! Path following: pseudo-arc-length continuation (Riks 1979; Keller 1977) with located events.
//!
//! The path (q, λ)(s) is followed with unit tangents in the norm ‖(q, λ)‖² = Σ (qᵢ/scaleᵢ)²/n +
//! (λ/λ_scale)², so that neither the mesh nor the units decide the step. Each step solves on the
//! hyperplane normal to the tangent of its start; limit points in λ are passed without notice,
//! and located afterwards where they are asked for.

#![allow(non_snake_case)]

use super::error::StaticsError;
use super::load_steps::analyse;
use super::newton::{Condition, Newton};
use super::path::{ArcLengthOptions, Event, PathSummary};
use super::{Iteration, Step};
use crate::failure::Failure;
use crate::linear_solver::{AutoSolver, LinearSolver};
use pullback_manifold::system::{ChartChanges, System};
use std::ops::ControlFlow;

/// Follows the equilibrium path of `system` from `q`, with the default solver.
///
/// # Errors
/// [`StaticsError`]: which step at which load failed, why, and with what residuals.
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
struct Place {
    q: Vec<f64>,
    lambda: f64,
    /// dq/ds and dλ/ds.
    dq: Vec<f64>,
    d_lambda: f64,
}

/// The norm in which arc length is measured.
struct Norm {
    /// Weight of each coordinate, 1/(n scale²).
    weights: Vec<f64>,
    /// Weight of the load, 1/load_scale².
    load: f64,
}

impl Norm {
    fn dot(&self, a: (&[f64], f64), b: (&[f64], f64)) -> f64 {
        let q: f64 = (a.0.iter().zip(b.0).zip(&self.weights))
            .map(|((a, b), w)| a * b * w)
            .sum();
        q + a.1 * b.1 * self.load
    }
}

/// As [`trace_path`], with a linear solver of the caller's choice.
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
    let mut at = Place {
        q: q.clone(),
        lambda: options.from,
        dq: vec![0.0; n],
        d_lambda: if options.forward { 1.0 } else { -1.0 },
    };
    out.summary.t = at.lambda;
    system.start(at.lambda, &at.q);
    let mut ds = options.first_step;
    let mut next = at.clone();
    let mut fresh = false;
    while out.summary.steps < options.max_steps {
        newton.history.clear();
        let mut outcome = Ok(());
        let mut changes = 0;
        if !fresh {
            let changed = system.change_charts(at.lambda, &mut at.q, &mut at.dq, &mut []);
            changes = changed.charts;
            outcome = tangent(&mut newton, solver, system, &mut at, &norm);
        }
        out.summary.chart_changes += changes;
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
        // A path that turns by more than this within one step may have been left for another.
        let bend = norm.dot((&at.dq, at.d_lambda), (&next.dq, next.d_lambda));
        if outcome.is_ok() && bend < SHARPEST_BEND {
            outcome = Err(Failure::Diverged);
        }
        out.summary.evaluations = newton.evaluations;
        out.summary.factorisations = newton.factorisations;
        if let Err(failure) = outcome {
            out.summary.rejected += 1;
            fresh = false;
            let to = at.lambda + ds * at.d_lambda;
            let failed = newton.fail(system, failure, &out.summary, to);
            ds *= 0.5;
            if ds < options.min_step {
                q.copy_from_slice(&at.q);
                return Err(StaticsError::Step(failed));
            }
            continue;
        }
        out.summary.steps += 1;
        out.summary.iterations += iterations;
        let located = locate_events(&mut newton, solver, system, &at, &next, ds, &norm, options);
        let moved = !located.is_empty();
        for Located { index, s, place } in located {
            out.events.push((index, place.lambda));
            newton
                .evaluate(system, None, &place.q, place.lambda)
                .map_err(|source| {
                    let failure = Failure::System(source);
                    StaticsError::Step(newton.fail(system, failure, &out.summary, place.lambda))
                })?;
            let report = Step {
                number: out.summary.steps,
                t: place.lambda,
                step_size: s,
                q: &place.q,
                iterations: newton.iterations(),
                residuals: &newton.history,
                chart_changes: changes,
                event: Some(index),
            };
            let flow = observer(system, &report);
            if options.events[index].1 || flow.is_break() {
                q.copy_from_slice(&place.q);
                out.summary.t = place.lambda;
                out.summary.finished = options.events[index].1;
                return Ok(out);
            }
        }
        std::mem::swap(&mut at, &mut next);
        out.summary.t = at.lambda;
        if moved {
            // Locating events has moved the system: bring it back.
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
        };
        if observer(system, &report).is_break() {
            break;
        }
        // The tangent just found serves the next step, unless charts change.
        let changed = system.change_charts(at.lambda, &mut at.q, &mut at.dq, &mut []);
        out.summary.chart_changes += changed.charts;
        fresh = changed == ChartChanges::default();
        let ease = (options.target_iterations as f64 / iterations.max(1) as f64).sqrt();
        let straightness = if bend < GENTLE_BEND { 0.7 } else { 1.5 };
        ds = (ds * ease.clamp(0.5, straightness)).min(options.max_step);
    }
    q.copy_from_slice(&at.q);
    Ok(out)
}

/// Cosine between successive tangents below which a step is rejected.
const SHARPEST_BEND: f64 = 0.6;
/// Cosine below which the next step is shorter.
const GENTLE_BEND: f64 = 0.9;

/// Unit tangent at a place, in the sense of the one it has.
fn tangent<Y: System + ?Sized>(
    newton: &mut Newton,
    solver: &mut dyn LinearSolver,
    system: &mut Y,
    at: &mut Place,
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

/// Predict along the tangent and correct on the hyperplane normal to it.
#[allow(clippy::too_many_arguments, reason = "a private step of one algorithm")]
fn advance<Y: System + ?Sized>(
    newton: &mut Newton,
    solver: &mut dyn LinearSolver,
    system: &mut Y,
    at: &Place,
    ds: f64,
    norm: &Norm,
    next: &mut Place,
) -> Result<(), Failure> {
    for (q, (q0, dq)) in next.q.iter_mut().zip(at.q.iter().zip(&at.dq)) {
        *q = q0 + ds * dq;
    }
    next.lambda = at.lambda + ds * at.d_lambda;
    newton.history.clear();
    newton.history.push(Iteration {
        residual: [0.0; 3],
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

/// Value of an event's function at a place: zero where it happens.
fn event_value(event: Event, place: &Place) -> f64 {
    match event {
        Event::TurningPoint => place.d_lambda,
        Event::Load(load) => place.lambda - load,
        Event::Coordinate { unknown, value } => {
            place.q.get(unknown).map_or(f64::NAN, |q| q - value)
        }
    }
}

/// An event found within a step.
struct Located {
    index: usize,
    /// Distance from the step's start.
    s: f64,
    place: Place,
}

/// Change of an event's function, relative to its change over the step, that counts as zero.
///
/// At a turning point K is singular and λ has no slope: 1e-7 there leaves λ exact to round-off
/// and K solvable.
fn resolution(event: Event) -> f64 {
    match event {
        Event::TurningPoint => 1e-7,
        Event::Load(_) | Event::Coordinate { .. } => 1e-12,
    }
}

/// The events between `at` and `next`, in order.
#[allow(clippy::too_many_arguments, reason = "a private step of one algorithm")]
fn locate_events<Y: System + ?Sized>(
    newton: &mut Newton,
    solver: &mut dyn LinearSolver,
    system: &mut Y,
    at: &Place,
    next: &Place,
    ds: f64,
    norm: &Norm,
    options: &ArcLengthOptions,
) -> Vec<Located> {
    let mut found = Vec::new();
    for (index, &(event, _)) in options.events.iter().enumerate() {
        let (mut a, mut fa) = (0.0, event_value(event, at));
        let (mut b, mut fb) = (ds, event_value(event, next));
        // An event that cannot be evaluated (NaN) does not happen; one that happened at the start
        // was reported with the step before.
        let crossed = fa * fb < 0.0 || (fb == 0.0 && fa != 0.0);
        if !crossed {
            continue;
        }
        // Regula falsi with the Illinois modification; each trial is a converged place, and the
        // best of them is reported even where the last bit cannot be resolved.
        let size = fa.abs().max(fb.abs());
        let mut best = Located {
            index,
            s: ds,
            place: next.clone(),
        };
        let mut least = fb.abs();
        let mut trial = at.clone();
        for _ in 0..60 {
            if least <= resolution(event) * size || (b - a).abs() <= 1e-13 * ds {
                break;
            }
            let s = (a * fb - b * fa) / (fb - fa);
            trial.dq.copy_from_slice(&at.dq);
            trial.d_lambda = at.d_lambda;
            let converged = advance(newton, solver, system, at, s, norm, &mut trial).is_ok()
                && (event != Event::TurningPoint
                    || tangent(newton, solver, system, &mut trial, norm).is_ok());
            if !converged {
                break;
            }
            let f = event_value(event, &trial);
            if f.abs() < least {
                least = f.abs();
                best.s = s;
                best.place.clone_from(&trial);
            }
            if f * fb < 0.0 {
                (a, fa) = (b, fb);
            } else {
                fa *= 0.5;
            }
            (b, fb) = (s, f);
        }
        found.push(best);
    }
    found.sort_by(|x, y| x.s.total_cmp(&y.s));
    found
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
    Ok(())
}
