//! The largest frequency of K and M, and the stability limit of a step.

use super::{DynamicsError, Scheme, State};
use crate::failure::find_mechanism;
use crate::linear_solver::{LinearError, LinearSolver};
use pullback_manifold::system::{Evaluation, System, Weights};

/// Largest number of Lanczos steps.
const MOST: usize = 120;
/// Relative change of the largest Ritz value, over a few steps, at which it has converged.
const SETTLED: f64 = 1e-9;

/// The largest stable step of a conditionally stable scheme, from the largest frequency at this state;
/// rejects a step beyond it. The frequency is approached from below, to about six digits. If the motion
/// stiffens the system later, it is not evaluated again; the energy balance shows the instability.
pub(super) fn check_step(
    system: &mut dyn System,
    solver: &mut dyn LinearSolver,
    state: &State,
    scheme: &Scheme,
    step: f64,
    [r, S]: [&mut [f64]; 2],
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
    let massless = |system: &dyn System, source| DynamicsError::Massless {
        scheme: scheme.name,
        source,
        mechanism: find_mechanism(system, S),
    };
    let found = solver
        .factorise(S)
        .and_then(|()| largest(system, solver, [&K, S]));
    let square = found.map_err(|source| massless(system, source))?;
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

/// The largest ω² of K x = ω² M x by Lanczos' method with M⁻¹K in the scalar product of M, which is
/// already factorised.
fn largest(
    system: &dyn System,
    solver: &mut dyn LinearSolver,
    [K, M]: [&[f64]; 2],
) -> Result<f64, LinearError> {
    let pattern = system.pattern();
    let n = pattern.dim();
    let times = |A: &[f64], x: &[f64], y: &mut [f64]| {
        y.fill(0.0);
        pattern.multiply_add(1.0, A, x, y);
    };
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    // A start vector with a component of every mode.
    let mut x: Vec<f64> = (0..n).map(|i| 1.0 + (1.7 * (i * i) as f64).sin()).collect();
    let (mut before, mut y, mut Mx) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let (mut alphas, mut betas) = (Vec::new(), Vec::new());
    let (mut found, mut beta) = (0.0_f64, 0.0);
    for step in 0..MOST.min(n) {
        times(M, &x, &mut Mx);
        let size = dot(&x, &Mx).abs().sqrt();
        if size <= f64::EPSILON * beta || size == 0.0 {
            break;
        }
        if step > 0 {
            betas.push(size);
        }
        beta = size;
        x.iter_mut().for_each(|x| *x /= size);
        times(K, &x, &mut y);
        alphas.push(dot(&x, &y));
        solver.solve(Some(M), &mut y)?;
        let alpha = alphas[step];
        for i in 0..n {
            let back = if step > 0 { beta * before[i] } else { 0.0 };
            y[i] -= alpha * x[i] + back;
        }
        std::mem::swap(&mut before, &mut x);
        std::mem::swap(&mut x, &mut y);
        if step % 4 == 3 || step + 1 == MOST.min(n) {
            let value = top(&alphas, &betas);
            let settled = (value - found).abs() <= SETTLED * value.abs();
            found = value;
            if settled {
                break;
            }
        }
    }
    Ok(found.max(top(&alphas, &betas)))
}

/// The largest eigenvalue of a symmetric tridiagonal matrix, by bisection with Sturm's count.
fn top(alphas: &[f64], betas: &[f64]) -> f64 {
    let beta = |i: usize| betas.get(i).copied().unwrap_or(0.0).abs();
    let radius = |i: usize| beta(i) + if i > 0 { beta(i - 1) } else { 0.0 };
    let bounds = alphas
        .iter()
        .enumerate()
        .map(|(i, a)| (a - radius(i), a + radius(i)));
    let (mut low, mut high) = bounds.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (a, b)| {
        (l.min(a), h.max(b))
    });
    if low > high {
        return 0.0;
    }
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        // A positive pivot of A − middle is an eigenvalue above it.
        let (mut pivot, mut above) = (1.0_f64, false);
        for (i, alpha) in alphas.iter().enumerate() {
            let off = if i > 0 {
                beta(i - 1).powi(2) / pivot
            } else {
                0.0
            };
            pivot = alpha - middle - off;
            if pivot == 0.0 {
                pivot = -f64::MIN_POSITIVE;
            }
            above |= pivot > 0.0;
        }
        if above {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
