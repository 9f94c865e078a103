//! One step of the load: predict, correct, settle charts.

use super::Iteration;
use super::newton::Newton;
use crate::abilities::{charts, events};
use crate::failure::Cause;
use crate::linear_solver::LinearSolver;
use crate::rounding::largest;
use crate::vectors::add;
use pullback_manifold::domain::DomainError;
use pullback_manifold::system::{ChartChanges, Point, System, SystemError};

/// Largest number of changes of chart, and of nodes that slides pass, in a step.
const ROUNDS: usize = 20;

/// Part of its typical size by which a coordinate enters the next line.
const BEYOND: f64 = 1e-5;

/// State of the tangent at the beginning of a step.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum TangentStatus {
    Nothing,
    Evaluated,
    Factorised,
}

/// The coordinate of a slide that passes the first end of its line between two states, and its value there; `None` if none does.
fn departure(system: &mut dyn System, t: f64, from: &[f64], to: &[f64]) -> Option<(usize, f64)> {
    let mut passes = |from: &[f64]| {
        let by = events(system).value(Point::statics(t, from), Point::statics(t, to));
        (by >= 0.0).then_some(1.0 - by)
    };
    passes(from)?;
    let mut moved: Vec<usize> = (0..to.len()).filter(|&i| from[i] != to[i]).collect();
    moved.sort_by(|&a, &b| (to[b] - from[b]).abs().total_cmp(&(to[a] - from[a]).abs()));
    moved.into_iter().find_map(|i| {
        let mut others = to.to_vec();
        others[i] = from[i];
        let s = passes(&others)?;
        Some((i, from[i] + (to[i] - from[i]) * s * s * (3.0 - 2.0 * s)))
    })
}

impl Newton {
    /// The first correction, with the tangent at the old load; whether a prescribed motion moves equations of multipliers.
    pub(super) fn predict(
        &mut self,
        system: &mut dyn System,
        q: &mut [f64],
        [from, to]: [f64; 2],
        known: TangentStatus,
    ) -> Result<bool, Cause> {
        self.history.clear();
        if known == TangentStatus::Nothing {
            self.evaluate(system, None, q, from)
                .map_err(Cause::System)?;
        }
        if known != TangentStatus::Factorised {
            self.factorise()?;
        }
        // δq = K⁻¹ (r + r_t Δt): with r_t a prescribed support bends the whole structure, while the
        // residual alone would first strain the element next to it.
        for ((dq, r), rate) in self.dq.iter_mut().zip(&self.r).zip(&self.r_t) {
            *dq = r + rate * (to - from);
        }
        let residual = largest(system.pattern(), &self.dq, [0.0; 3]);
        let solved = self.solver.solve(Some(&self.S), &mut self.dq);
        solved.map_err(Cause::linear)?;
        add(q, 1.0, &self.dq);
        self.history.push(Iteration {
            residual,
            ratio: f64::INFINITY,
            correction: self.size(&self.dq),
            damping: 1.0,
        });
        let mut rates = system.pattern().coordinates().iter().zip(&self.r_t);
        Ok(rates.any(|(c, rate)| c.is_multiplier && *rate != 0.0))
    }

    /// Iterates to equilibrium at a fixed load, changes charts if needed, and restores equilibrium
    /// if the discretisation of an element depends on them, so that results do not depend on the
    /// path. The number of changes of chart.
    ///
    /// A slide passes the nodes of its chain
    /// one by one, as the force along the chain jumps there, and rests at one between lines that push it towards each other.
    pub(super) fn settle(
        &mut self,
        system: &mut dyn System,
        q: &mut [f64],
        t: f64,
        previous: Option<(f64, &[f64])>,
    ) -> Result<usize, Cause> {
        let held = self.held_coordinates.clone();
        let settled = self.settle_charts(system, q, t, previous);
        if settled.is_err() {
            self.held_coordinates = held;
        }
        settled
    }

    fn settle_charts(
        &mut self,
        system: &mut dyn System,
        q: &mut [f64],
        t: f64,
        previous: Option<(f64, &[f64])>,
    ) -> Result<usize, Cause> {
        let mut before = previous.map_or(&*q, |(_, q)| q).to_vec();
        self.correct(system, q, &mut { t }, None, previous)?;
        let (mut changes, mut rounds, mut passes) = (0, 0, None);
        for at in self.held_coordinates.clone() {
            changes += self.rest(system, q, t, at, 1.0)?;
        }
        for _ in 0..ROUNDS {
            if let Some((i, end)) = departure(system, t, &before, q) {
                passes = Some(i);
                let direction = q[i] - before[i];
                q[i] = end;
                before.copy_from_slice(q);
                self.held_coordinates.push((i, end));
                self.correct(system, q, &mut { t }, None, None)?;
                changes += self.rest(system, q, t, (i, end), direction)?;
                continue;
            }
            // If equilibrium moves an element back over its border, the second round is the last.
            if rounds == 2 {
                return Ok(changes);
            }
            let changed = charts(system).change_charts(t, q, &mut [], &mut []);
            changes += changed.charts;
            if changed == ChartChanges::default() {
                return Ok(changes);
            }
            rounds += 1;
            before.copy_from_slice(q);
            self.correct(system, q, &mut { t }, None, None)?;
        }
        Err(passes.map_or(Cause::TooManyIterations, |i| {
            let why = "it passes from node to node and back, as the force along its chain jumps there; a dynamic analysis with \
                       dampers finds where it comes to rest";
            Cause::System(SystemError::Domain {
                what: system.name(i),
                why: DomainError::Undefined(why.to_owned()),
            })
        }))
    }

    /// Releases a slide that is held at the end of a line unless the lines on both sides push it there: it goes on along the
    /// line that does not. The number of changes of chart.
    fn rest(
        &mut self,
        system: &mut dyn System,
        q: &mut [f64],
        t: f64,
        (i, end): (usize, f64),
        direction: f64,
    ) -> Result<usize, Cause> {
        let mut changes = 0;
        let held = std::mem::take(&mut self.held_coordinates);
        let beyond = (BEYOND * system.pattern().coordinates()[i].size).copysign(direction);
        let mut push = |newton: &mut Self, q: &mut [f64], beyond: f64| {
            q[i] = end + beyond;
            changes += charts(system).change_charts(t, q, &mut [], &mut []).charts;
            q[i] = end;
            let evaluated = newton.evaluate(system, None, q, t);
            evaluated
                .map(|()| newton.r[i] * beyond)
                .map_err(Cause::System)
        };
        let back = push(self, q, -beyond)?;
        let ahead = push(self, q, beyond)?;
        if ahead <= 0.0 && back > 0.0 {
            push(self, q, -beyond)?;
        }
        self.held_coordinates = held;
        if ahead > 0.0 || back > 0.0 {
            self.held_coordinates.retain(|(k, _)| *k != i);
        }
        self.correct(system, q, &mut { t }, None, None)?;
        Ok(changes)
    }

    /// Factorises the tangent at an equilibrium for the next step, and counts its unstable
    /// directions. A singular tangent fails the next step, if any.
    pub(super) fn prepare(&mut self, system: &dyn System) -> (TangentStatus, Option<usize>) {
        if system.is_symmetric() && self.factorise().is_ok() {
            return (TangentStatus::Factorised, self.unstable(system));
        }
        (TangentStatus::Evaluated, None)
    }
}
