//! The largest frequency of K and M, and the stability limit of a step.

use super::{DynamicsError, Scheme, State, Stepper};
use crate::failure::find_mechanism;
use crate::linear_solver::{AutoSolver, LinearError, LinearSolver};
use crate::linearization::Krylov;
use pullback_manifold::system::{Evaluation, System, Weights};

/// Largest number of Lanczos steps.
const MOST: usize = 120;
/// Steps between two looks at the largest Ritz value; a divisor of `MOST`.
const LOOK: usize = 4;
/// Relative change between two looks at which it has converged.
const SETTLED: f64 = 1e-9;

/// The largest stable step of a conditionally stable scheme, from the largest frequency at this state;
/// rejects a step beyond it. The frequency is approached from below, to about six digits. If the motion
/// stiffens the system later, it is not evaluated again; the energy balance shows the instability.
pub(super) fn check_step(
    system: &mut dyn System,
    Stepper { solver, r, S, .. }: &mut Stepper,
    state: &State,
    scheme: &Scheme,
    step: f64,
) -> Result<Option<f64>, DynamicsError> {
    let Some(limit) = scheme.properties().limit else {
        return Ok(None);
    };
    let mut tangent = |weights, S: &mut [f64]| {
        let out = Evaluation::with_tangent(r, weights, S);
        let evaluated = system.evaluate(state.point(), out);
        evaluated.map_err(DynamicsError::at(state.t))
    };
    let mut K = vec![0.0; S.len()];
    tangent(Weights::STATIC, &mut K)?;
    tangent(Weights::MASS, S)?;
    let found = solver
        .factorise(S)
        .and_then(|()| largest(system, solver, [&K, S]));
    let square = found.map_err(|source| DynamicsError::Massless {
        scheme: scheme.name,
        source,
        mechanism: find_mechanism(system, S),
    })?;
    let frequency = square.max(0.0).sqrt();
    if step * frequency <= limit {
        return Ok(Some(limit / frequency).filter(|h| h.is_finite()));
    }
    let ratios = system.pattern().diagonal().map(|k| K[k] / S[k]).enumerate();
    let stiffest = ratios.max_by(|(_, a), (_, b)| a.total_cmp(b));
    Err(DynamicsError::StepTooLarge {
        scheme: scheme.name,
        step,
        stable: limit / frequency,
        frequency,
        what: stiffest.map_or_else(String::new, |(i, _)| system.name(i)),
    })
}

/// The largest ω² of K x = ω² M x in a Krylov subspace of M⁻¹K, with the scalar product of M, which is
/// already factorised.
fn largest(
    system: &dyn System,
    solver: &mut AutoSolver,
    [K, M]: [&[f64]; 2],
) -> Result<f64, LinearError> {
    let pattern = system.pattern();
    let gram = |x: &[f64], y: &mut [f64]| pattern.multiply_add(1.0, M, x, y);
    let mut krylov = Krylov::new([pattern.dim(); 2], true, gram);
    // A start vector with a component of every mode.
    let start = (0..pattern.dim()).map(|i| 1.0 + (1.7 * (i * i) as f64).sin());
    krylov.add(start.collect());
    let mut found = 0.0_f64;
    while krylov.len() < MOST
        && let Some((v, _)) = krylov.next()
    {
        let mut product = vec![0.0; v.len()];
        pattern.multiply_add(1.0, K, v, &mut product);
        solver.solve(Some(M), &mut product)?;
        krylov.take(product);
        if krylov.len().is_multiple_of(LOOK) || krylov.is_exhausted() {
            let pairs = krylov.ritz().unwrap_or_default();
            let value = pairs.iter().map(|pair| pair.theta.re).fold(0.0, f64::max);
            let settled = (value - found).abs() <= SETTLED * value.abs();
            found = value;
            if settled {
                break;
            }
        }
    }
    Ok(found)
}
