//! One step of the load: predict, correct, settle charts.

use super::Iteration;
use super::error::StaticsError;
use super::newton::Newton;
use crate::abilities::change_charts;
use crate::failure::Failure;
use crate::linear_solver::{LinearSolver, Symmetry};
use pullback_manifold::system::{ChartChanges, System};

/// State of the tangent at the beginning of a step.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Known {
    Nothing,
    Evaluated,
    Factorised,
}

/// The first correction, with the tangent at the old load.
pub(super) fn predict(
    newton: &mut Newton,
    solver: &mut dyn LinearSolver,
    system: &mut dyn System,
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

pub(super) fn correct(
    newton: &mut Newton,
    solver: &mut dyn LinearSolver,
    system: &mut dyn System,
    q: &mut [f64],
    t: f64,
    previous: Option<(f64, &[f64])>,
) -> Result<(), Failure> {
    let mut lambda = t;
    newton.correct(system, solver, q, &mut lambda, None, previous)
}

/// Changes charts if needed, and restores equilibrium if the discretisation of an element depends
/// on them, so that results do not depend on the path.
pub(super) fn settle(
    newton: &mut Newton,
    solver: &mut dyn LinearSolver,
    system: &mut dyn System,
    q: &mut [f64],
    t: f64,
) -> Result<usize, Failure> {
    let mut changes = 0;
    // If equilibrium moves an element back over its border, the second round is the last.
    for _ in 0..2 {
        let changed = change_charts(system, t, q, &mut [], &mut []);
        changes += changed.charts;
        if changed == ChartChanges::default() {
            break;
        }
        correct(newton, solver, system, q, t, None)?;
    }
    Ok(changes)
}

pub(super) fn analyse(
    solver: &mut dyn LinearSolver,
    system: &dyn System,
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
