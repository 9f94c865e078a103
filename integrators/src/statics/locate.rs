//! Events within a step along a path, located to round-off.
//!
//! An event is an equilibrium with its load or coordinate, or a critical point. If none is found
//! within the step, the step was too large to know the path between its ends and is rejected, like one
//! that did not converge. Reported states are at the event, converged, and on the same path.

use super::arc_length::{Norm, Position, SHARPEST_BEND};
use super::critical::{CriticalKind, PathDirection};
use super::newton::Newton;
use super::{Event, Iteration};
use crate::failure::Cause;
use pullback_manifold::system::System;

/// A converged step along the path.
#[derive(Clone, Copy)]
pub(super) struct PathStep<'a> {
    pub at: &'a Position,
    pub next: &'a Position,
    /// Its length.
    pub ds: f64,
    /// Length within which several bifurcations are one.
    pub finest: f64,
    pub norm: &'a Norm,
    /// Unstable directions at its ends.
    pub unstable: [Option<usize>; 2],
}

/// An event found within a step.
pub(super) struct Located {
    pub index: usize,
    /// Distance from the step's start.
    pub s: f64,
    pub position: Position,
    /// The path that crosses this one at a bifurcation.
    pub branch: Option<PathDirection>,
    /// Number of directions that become stable or unstable at bifurcations of the step.
    pub directions: usize,
    /// Linear solutions to find it.
    pub iterations: usize,
    /// History of the iterations there.
    pub history: Vec<Iteration>,
    pub unstable: Option<usize>,
}

impl PathStep<'_> {
    /// Whether an event lies within the step, its end included.
    fn passes(&self, event: Event) -> bool {
        let [before, after] = [self.at, self.next].map(|p| event_value(event, p));
        match event {
            Event::Bifurcation => self.directions() > 0,
            // An event that cannot be evaluated (NaN) is ignored; one at the start was reported with
            // the step before.
            _ => before * after < 0.0 || (after == 0.0 && before != 0.0),
        }
    }

    /// Least number of directions that become stable or unstable at bifurcations of the step, as far as known. At a turning
    /// point one does, too.
    fn directions(&self) -> usize {
        let [before, after] = self.unstable;
        let change = before.zip(after).map(|(a, b)| a.abs_diff(b));
        change.map_or(0, |n| n.abs_diff(self.turns().into()))
    }

    fn turns(&self) -> bool {
        self.passes(Event::TurningPoint)
    }

    /// Whether the step has several critical points, or a multiple one.
    fn is_multiple(&self) -> bool {
        self.directions() + usize::from(self.turns()) > 1
    }

    /// What `newton` has found at a position, if that lies on the path within the step.
    fn located(&self, newton: &Newton, position: Position) -> Option<Located> {
        let s = self.norm.distance(self.at, &position.q, position.t);
        let within = s > -START * self.ds && s <= self.ds;
        (within && !self.norm.strays(self.at, &position, s)).then(|| Located {
            index: 0,
            s,
            position,
            branch: None,
            directions: 0,
            iterations: newton.iterations(),
            history: newton.history.clone(),
            unstable: None,
        })
    }

    /// An event at its end.
    fn end(&self) -> Located {
        Located {
            index: 0,
            s: self.ds,
            position: self.next.clone(),
            branch: None,
            directions: 0,
            iterations: 0,
            history: Vec::new(),
            unstable: None,
        }
    }

    /// Unit tangents of paths forward along the step, that of its own path first.
    fn oriented(&self, paths: &[PathDirection]) -> (Option<PathDirection>, Option<PathDirection>) {
        let oriented = |path: &PathDirection| {
            let length = self.norm.dot(path, path).sqrt();
            let cosine = self.norm.dot(&self.at.tangent, path) / length;
            let sense = cosine.signum() / length;
            let dq = path.dq.iter().map(|dq| sense * dq).collect();
            let dt = sense * path.dt;
            (cosine.abs(), PathDirection { dq, dt })
        };
        let mut all: Vec<_> = paths.iter().map(oriented).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut all = all.into_iter().map(|(_, path)| path);
        (all.next(), all.next())
    }
}

/// Value of the event function at a position: zero at the event. Bifurcations have none.
fn event_value(event: Event, position: &Position) -> f64 {
    match event {
        Event::TurningPoint => position.tangent.dt,
        Event::Bifurcation => f64::NAN,
        Event::Load(load) => position.t - load,
        Event::Coordinate { unknown, value } => {
            position.q.get(unknown).map_or(f64::NAN, |q| q - value)
        }
    }
}

/// An event in words.
fn describe(system: &dyn System, event: Event) -> String {
    match event {
        Event::TurningPoint => "a turning point".to_owned(),
        Event::Bifurcation => "a bifurcation".to_owned(),
        Event::Load(load) => format!("load parameter {load}"),
        Event::Coordinate { unknown, value } => format!("{} = {value}", system.name(unknown)),
    }
}

/// Parts at which a step is divided, not where a symmetric structure may have a bifurcation; the second one where the
/// tangent is singular at the first.
const MIDDLES: [f64; 2] = [0.47, 0.31];
/// Length of a step in which several bifurcations have one load, relative to that in which they are one.
const ONE_LOAD: f64 = 1e-6;
/// A bifurcation at the start of a step, relative to its length, where the step before could not count.
const START: f64 = 1e-6;

/// The events of a step, in order.
pub(super) fn locate(
    newton: &mut Newton,
    system: &mut dyn System,
    step: PathStep<'_>,
    events: &[(Event, bool)],
) -> Result<Vec<Located>, Cause> {
    let counts = events.iter().any(|(event, _)| *event == Event::Bifurcation);
    if step.ds > step.finest
        && (counts && step.is_multiple())
        && let Some(found) = locate_in_parts(newton, system, step, events)?
    {
        return Ok(found);
    }
    let mut found = Vec::new();
    for (index, &(event, _)) in events.iter().enumerate() {
        if step.passes(event) {
            let mut one = match event {
                Event::TurningPoint | Event::Bifurcation => {
                    match find_critical(newton, system, step, event) {
                        // Several directions of one load have no simple critical point.
                        Err(_) if event == Event::Bifurcation && step.is_multiple() => {
                            if step.ds > ONE_LOAD * step.finest
                                && let Ok(Some(found)) =
                                    locate_in_parts(newton, system, step, events)
                            {
                                return Ok(found);
                            }
                            Located {
                                directions: step.directions() + usize::from(step.turns()),
                                ..step.end()
                            }
                        }
                        found => found?,
                    }
                }
                _ if event_value(event, step.next) == 0.0 => Located {
                    history: newton.history.clone(),
                    unstable: step.unstable[1],
                    ..step.end()
                },
                Event::Load(_) | Event::Coordinate { .. } => find(newton, system, step, event)?,
            };
            let bend = (step.norm).dot(&step.at.tangent, &one.position.tangent);
            if bend < SHARPEST_BEND {
                return Err(unlocated(system, event));
            }
            one.index = index;
            found.push(one);
        }
    }
    found.sort_by(|x, y| x.s.total_cmp(&y.s));
    Ok(found)
}

/// The events of a step with several bifurcations, from those of its two parts; `None` where the step is so short that its
/// tangents are singular.
fn locate_in_parts(
    newton: &mut Newton,
    system: &mut dyn System,
    step: PathStep<'_>,
    events: &[(Event, bool)],
) -> Result<Option<Vec<Located>>, Cause> {
    let PathStep { at, next, norm, .. } = step;
    let mut middle = at.clone();
    for part in MIDDLES {
        let ds = part * step.ds;
        let reached = newton.advance(system, at, ds, None, norm, &mut middle);
        let iterations = newton.iterations();
        let solved = reached.and_then(|()| newton.tangent(system, &mut middle, norm));
        let unstable = solved.ok().and_then(|()| newton.unstable(system));
        if unstable.is_none() {
            continue;
        }
        let first = PathStep {
            next: &middle,
            ds,
            unstable: [step.unstable[0], unstable],
            ..step
        };
        let second = PathStep {
            at: &middle,
            ds: norm.distance(&middle, &next.q, next.t),
            unstable: [unstable, step.unstable[1]],
            ..step
        };
        let mut found = locate(newton, system, first, events)?;
        let mut others = locate(newton, system, second, events)?;
        others.iter_mut().for_each(|one| one.s += ds);
        found.append(&mut others);
        if let Some(one) = found.first_mut() {
            one.iterations += iterations;
        }
        return Ok(Some(found));
    }
    Ok(None)
}

fn unlocated(system: &dyn System, event: Event) -> Cause {
    let position = describe(system, event);
    Cause::Unlocated { position }
}

/// A critical point by its extended system.
fn find_critical(
    newton: &mut Newton,
    system: &mut dyn System,
    step: PathStep<'_>,
    event: Event,
) -> Result<Located, Cause> {
    let PathStep { at, next, .. } = step;
    // The slope of the load is zero at a turning point, where the path has the direction of ψ.
    let (part, shape, kind) = match event {
        Event::TurningPoint => (
            at.tangent.dt / (at.tangent.dt - next.tangent.dt),
            Some(&next.tangent.dq[..]),
            CriticalKind::Limit,
        ),
        _ => (0.5, None, CriticalKind::Bifurcation),
    };
    let between = |a: f64, b: f64| a + part * (b - a);
    let q: Vec<f64> = (at.q.iter().zip(&next.q))
        .map(|(a, b)| between(*a, *b))
        .collect();
    let guess = (&q[..], between(at.t, next.t));
    let point = newton.critical_point(system, guess, shape);
    let point = point.map_err(|_| unlocated(system, event))?;
    let (along, branch) = step.oriented(&point.paths);
    // A symmetric branch of a bifurcation turns there.
    let turns = |path: &PathDirection| event == Event::TurningPoint && path.dt == 0.0;
    let Some(tangent) = along.filter(|path| point.kind == kind || turns(path)) else {
        return Err(unlocated(system, event));
    };
    let position = Position {
        q: point.q,
        t: point.t,
        tangent,
    };
    let found = step.located(newton, position);
    let found = found.ok_or_else(|| unlocated(system, event))?;
    Ok(Located {
        branch,
        directions: step.directions(),
        ..found
    })
}

/// The equilibrium at the load or coordinate of an event.
fn find(
    newton: &mut Newton,
    system: &mut dyn System,
    step: PathStep<'_>,
    event: Event,
) -> Result<Located, Cause> {
    let PathStep { at, next, norm, .. } = step;
    let [before, after] = [at, next].map(|position| event_value(event, position));
    let ds = step.ds * before / (before - after);
    let mut position = at.clone();
    newton.advance(system, at, ds, Some(event), norm, &mut position)?;
    let found = step.located(newton, position);
    let mut found = found.ok_or_else(|| unlocated(system, event))?;
    // If the tangent is singular, its direction is unknown.
    if (newton.tangent(system, &mut found.position, norm)).is_ok() {
        found.unstable = newton.unstable(system);
    }
    Ok(found)
}
