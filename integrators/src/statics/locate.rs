//! Events within a step along a path, located to round-off.
//!
//! Each trial is an equilibrium found from the start of the step, at another distance. If a trial
//! does not converge, or an event function does not reach zero, the step was too large to know the
//! path between its ends and is rejected, like one that did not converge. Reported states are at
//! the event, converged, and on the same path.

use super::arc_length::{Norm, Position, SHARPEST_BEND};
use super::newton::Newton;
use super::{ArcLengthOptions, Event, Iteration, Problem};
use crate::failure::Cause;
use pullback_manifold::system::System;

/// An event found within a step.
pub(super) struct Located {
    pub index: usize,
    /// Distance from the step's start.
    pub s: f64,
    pub position: Position,
    /// Linear solutions to find it.
    pub iterations: usize,
    /// History of the iterations there.
    pub history: Vec<Iteration>,
    pub unstable: Option<usize>,
}

/// Value of the event function at a position: zero at the event.
fn event_value(event: Event, position: &Position) -> f64 {
    match event {
        Event::TurningPoint => position.d_lambda,
        Event::Load(load) => position.lambda - load,
        Event::Coordinate { unknown, value } => {
            position.q.get(unknown).map_or(f64::NAN, |q| q - value)
        }
    }
}

/// An event in words.
fn describe(system: &dyn System, event: Event) -> String {
    match event {
        Event::TurningPoint => "a turning point".to_owned(),
        Event::Load(load) => format!("load parameter {load}"),
        Event::Coordinate { unknown, value } => format!("{} = {value}", system.name(unknown)),
    }
}

/// Change of an event function, relative to its change over the step, that counts as zero.
///
/// At a turning point K is singular and λ has no slope: 1e-7 there leaves λ exact to round-off
/// and K solvable.
fn resolution(event: Event) -> f64 {
    match event {
        Event::TurningPoint => 1e-7,
        Event::Load(_) | Event::Coordinate { .. } => 1e-12,
    }
}

/// Largest value of an event function at which the event counts as found.
///
/// At a turning point the error of λ is the square of its slope.
fn largest_miss(event: Event, newton: &Newton, options: &ArcLengthOptions) -> f64 {
    match event {
        Event::TurningPoint => 1e-5 * options.load_scale,
        Event::Load(load) => 1e-9 * (load.abs() + options.load_scale),
        Event::Coordinate { unknown, value } => {
            1e-9 * (value.abs() + 1.0 / newton.inverse_scale[unknown])
        }
    }
}

/// The events of a step (start, end, distance), in order.
pub(super) fn locate(
    newton: &mut Newton,
    problem: &mut Problem<'_>,
    step: (&Position, &Position, f64),
    norm: &Norm,
    options: &ArcLengthOptions,
) -> Result<Vec<Located>, Cause> {
    let (at, next, _) = step;
    let mut found = Vec::new();
    for (index, &(event, _)) in options.events.iter().enumerate() {
        let (fa, fb) = (event_value(event, at), event_value(event, next));
        // An event that cannot be evaluated (NaN) is ignored; one at the start was reported with
        // the step before.
        if fa * fb < 0.0 || (fb == 0.0 && fa != 0.0) {
            let mut one = find(newton, problem, step, norm, event)?;
            let missed =
                event_value(event, &one.position).abs() > largest_miss(event, newton, options);
            let position = &mut one.position;
            if event != Event::TurningPoint {
                position.dq.copy_from_slice(&at.dq);
                position.d_lambda = at.d_lambda;
                // If the tangent is singular, its direction is unknown.
                if newton.tangent(problem, position, norm).is_ok() {
                    one.unstable = newton.unstable(problem);
                }
            }
            let bend = norm.dot((&at.dq, at.d_lambda), (&position.dq, position.d_lambda));
            if missed || bend < SHARPEST_BEND {
                let position = describe(problem.system, event);
                return Err(Cause::Unlocated { position });
            }
            one.index = index;
            found.push(one);
        }
    }
    found.sort_by(|x, y| x.s.total_cmp(&y.s));
    Ok(found)
}

/// Regula falsi with the Illinois modification; returns the best trial, even if the last bit cannot
/// be resolved.
fn find(
    newton: &mut Newton,
    problem: &mut Problem<'_>,
    (at, next, ds): (&Position, &Position, f64),
    norm: &Norm,
    event: Event,
) -> Result<Located, Cause> {
    let (mut a, mut fa) = (0.0, event_value(event, at));
    let (mut b, mut fb) = (ds, event_value(event, next));
    let size = fa.abs().max(fb.abs());
    let mut trial = at.clone();
    let mut least = f64::INFINITY;
    let mut best = Located {
        index: 0,
        s: ds,
        position: next.clone(),
        iterations: 0,
        history: Vec::new(),
        unstable: None,
    };
    // The first trial is the end itself if the event is there.
    for _ in 0..60 {
        let s = if fb == 0.0 {
            ds
        } else {
            (a * fb - b * fa) / (fb - fa)
        };
        trial.dq.copy_from_slice(&at.dq);
        trial.d_lambda = at.d_lambda;
        if let Err(failure) = newton.advance(problem, at, s, norm, &mut trial) {
            if least.is_finite() {
                break;
            }
            return Err(failure);
        }
        best.iterations += newton.iterations();
        let history = newton.history.clone();
        // At the turning point itself the tangent is singular.
        if event == Event::TurningPoint && newton.tangent(problem, &mut trial, norm).is_err() {
            break;
        }
        let f = event_value(event, &trial);
        if f.abs() < least {
            least = f.abs();
            best.s = s;
            best.position.clone_from(&trial);
            best.history = history;
        }
        if f * fb < 0.0 {
            (a, fa) = (b, fb);
        } else {
            fa *= 0.5;
        }
        (b, fb) = (s, f);
        if least <= resolution(event) * size || (b - a).abs() <= 1e-13 * ds {
            break;
        }
    }
    Ok(best)
}
