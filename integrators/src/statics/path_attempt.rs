//! One attempt at a step along a path, which ends at a kink of a function of the load parameter at the latest.

use super::arc_length::SHARPEST_BEND;
use super::locate::{Located, PathStep, locate};
use super::path_run::PathRun;
use super::{Event, Iteration};
use crate::failure::Cause;
use pullback_manifold::system::System;

/// Part of a step within which several bifurcations are one.
const ONE_POINT: f64 = 1e-3;

/// A converged step whose events and end are not reported yet.
pub(super) struct Converging {
    pub located: std::vec::IntoIter<Located>,
    /// Whether locating events has moved the system.
    pub moved: bool,
    pub iterations: usize,
    /// Iterations of the step and its events that no row has reported yet.
    pub unreported: usize,
    pub history: Vec<Iteration>,
    /// Its length.
    pub ds: f64,
    /// Cosine between the tangents at its ends; `None` if it ends at a kink.
    pub bend: Option<f64>,
    pub unstable: Option<usize>,
}

impl PathRun {
    /// The length of the next step, and the kink of a function of t at which it ends, if there is one ahead.
    pub(super) fn goal(&self) -> (f64, Option<f64>) {
        let distance = |kink: f64| (kink - self.at.t) / self.at.tangent.dt;
        let ahead = self.kinks.iter().map(|&kink| (distance(kink), Some(kink)));
        let ahead = ahead.filter(|(ds, _)| *ds > 0.0 && *ds <= self.ds);
        let first = ahead.min_by(|a, b| a.0.total_cmp(&b.0));
        first.unwrap_or((self.ds, None))
    }

    /// A step from the present position, with its tangent and the events within it. Before a kink functions of t are
    /// those of the path so far.
    pub(super) fn attempt(
        &mut self,
        system: &mut dyn System,
        mut ds: f64,
        kink: Option<f64>,
    ) -> Result<Converging, Cause> {
        let (at, next, norm) = (&self.at, &mut self.next, &self.norm);
        let newton = &mut self.newton;
        let before = |kink: f64| {
            Event::Load(match at.tangent.dt > 0.0 {
                true => kink.next_down(),
                false => kink,
            })
        };
        newton
            .advance(system, at, ds, kink.map(before), norm, next)
            .map_err(off_path)?;
        if kink.is_some() {
            ds = norm.distance(at, &next.q, next.t);
        }
        if self.kinks.iter().any(|k| (k - at.t) * (k - next.t) < 0.0) {
            return Err(Cause::OffPath);
        }
        let (iterations, history) = (newton.iterations(), newton.history.clone());
        next.tangent.clone_from(&at.tangent);
        newton.tangent(system, next, norm).map_err(off_path)?;
        let bend = norm.dot(&at.tangent, &next.tangent);
        // The step back from its end must arrive as well.
        if bend < SHARPEST_BEND || norm.strays(at, next, ds) || norm.strays(next, at, -ds) {
            return Err(Cause::OffPath);
        }
        next.t = kink.unwrap_or(next.t);
        let unstable = newton.unstable(system);
        let step = PathStep {
            at,
            next,
            ds,
            finest: ONE_POINT * ds,
            norm,
            unstable: [self.unstable, unstable],
        };
        let located = locate(newton, system, step, &self.options.events)?;
        Ok(Converging {
            moved: !located.is_empty(),
            unreported: iterations + located.iter().map(|l| l.iterations).sum::<usize>(),
            located: located.into_iter(),
            iterations,
            history,
            ds,
            bend: kink.is_none().then_some(bend),
            unstable,
        })
    }
}

/// A correction that diverges along a path has left it.
pub(super) fn off_path(failure: Cause) -> Cause {
    match failure {
        Cause::Diverged => Cause::OffPath,
        other => other,
    }
}
