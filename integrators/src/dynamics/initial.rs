//! Consistent initial accelerations, M q̈ = r(t, q, q̇, 0), and multipliers.

#![allow(non_snake_case)]

use super::{DynamicsError, State};
use crate::failure::mechanism;
use crate::linear_solver::{LinearError, LinearSolver};
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::{Evaluation, Point, System, Weights};

/// A state with given coordinates and velocities; accelerations are found when a run begins.
///
/// The velocities are those just before `t`. Where a prescribed velocity jumps there, what is free takes the
/// impulse before the first step, as at any later jump.
///
/// # Errors
/// [`DynamicsError::Initial`] when a vector has not the system's dimension or is not finite. An
/// empty vector stands for zeros.
pub fn start<Y: System + ?Sized>(
    system: &Y,
    t: f64,
    q: &[f64],
    v: &[f64],
) -> Result<State, DynamicsError> {
    let n = system.pattern().dim();
    let take = |what: &'static str, x: &[f64]| {
        let problem = if x.is_empty() {
            return Ok(vec![0.0; n]);
        } else if x.len() != n {
            format!("{} given where the system has {n} coordinates", x.len())
        } else if let Some(i) = x.iter().position(|x| !x.is_finite()) {
            format!("{} is {}", system.name(i), x[i])
        } else {
            return Ok(x.to_vec());
        };
        Err(DynamicsError::Initial { what, problem })
    };
    if !t.is_finite() {
        return Err(DynamicsError::Initial {
            what: "time",
            problem: format!("is {t}"),
        });
    }
    Ok(State {
        t,
        q: take("coordinates", q)?,
        v: take("velocities", v)?,
        a: Vec::new(),
        algorithmic: Vec::new(),
    })
}

/// Fills the accelerations of a state, true and algorithmic, from the equations of motion, and its
/// multipliers; and the velocities of what has damping but no mass, which leaves them no choice.
///
/// The residual is linear in q̈ and λ, so one linear solution suffices:
/// [M h_xᵀ; h_x 0] (q̈, λ) = (r, −ḧ at q̈ = 0).
///
/// Accelerations that the state has already are corrected, with r and ḧ at these: coordinates without
/// mass, for which nothing but a step can find them, go on with what they had.
pub(super) fn accelerate<Y: System + ?Sized>(
    system: &mut Y,
    solver: &mut dyn LinearSolver,
    state: &mut State,
    h: f64,
    [r, S]: [&mut [f64]; 2],
) -> Result<(), DynamicsError> {
    let n = state.q.len();
    state.a.resize(n, 0.0);
    let multipliers = |i: &usize| system.is_multiplier(*i);
    let multipliers: Vec<usize> = (0..n).filter(multipliers).collect();
    for &i in &multipliers {
        (state.q[i], state.v[i], state.a[i]) = (0.0, 0.0, 0.0);
    }
    let mut passes = 1;
    let regular = solve_mass(system, solver, state, (h, 0.0), [&mut *r, &mut *S], None)?;
    if !regular {
        solve_rates(system, solver, state, [&mut *r, &mut *S])?;
        solve_mass(system, solver, state, (h, 0.0), [&mut *r, &mut *S], None)?;
    } else if is_damped(system, state)? {
        passes = PASSES;
    }
    for _ in 0..passes {
        if passes > 1 {
            let buffers = [&mut *r, &mut *S];
            solve_mass(system, solver, state, (h, h), buffers, None)?;
        }
        add(&mut state.a, 1.0, r);
    }
    for &i in &multipliers {
        (state.q[i], state.a[i]) = (r[i], 0.0);
    }
    state.algorithmic.clone_from(&state.a);
    Ok(())
}

/// Whether dampers take power at a state.
fn is_damped<Y: System + ?Sized>(system: &mut Y, state: &State) -> Result<bool, DynamicsError> {
    let energies = system.energies(point(state));
    let energies = energies.map_err(|source| DynamicsError::System { t: state.t, source })?;
    Ok(energies.is_some_and(|now| now.dissipated > 0.0))
}

/// Solutions with M + h C in place of M where there are dampers.
///
/// What relaxes within a step, λh ≫ 1 with λ = C/M, would be thrown by a jump and come back at once, which no step
/// shows: 4/(λh) of it remains. What steps resolve is exact but for (λh)⁴.
const PASSES: usize = 4;

fn add(x: &mut [f64], sign: f64, more: &[f64]) {
    x.iter_mut()
        .zip(more)
        .for_each(|(x, more)| *x += sign * more);
}

fn point(state: &State) -> Point<'_> {
    Point {
        t: state.t,
        q: &state.q,
        v: &state.v,
        a: &state.a,
    }
}

/// Where a driven velocity jumps, the momentum of the free coordinates does not: their velocities jump
/// by M⁻¹ (p₋ − p₊), p₊ the momentum with the new drive and the old velocities. Where a map was handed
/// over the same is done until p is kept, p what [`System::kept_momentum`] says. Returns how often.
pub(super) fn apply_impulse<Y: System + ?Sized>(
    system: &mut Y,
    solver: &mut dyn LinearSolver,
    state: &mut State,
    (before, driven): (&[f64], bool),
    t: f64,
    h: f64,
    [r, S, missing]: [&mut [f64]; 3],
) -> Result<usize, DynamicsError> {
    let largest = |p: &[f64]| p.iter().fold(0.0_f64, |m, p| m.max(p.abs()));
    let (mut damping, mut most) = (0.0, if driven { 1 } else { IMPULSES });
    let mut count = 0;
    while count < most {
        let at = Point { t, ..point(state) };
        let known = match driven {
            true => system.momentum(at, missing),
            false => system.kept_momentum(Some(at), missing),
        };
        known.map_err(|source| DynamicsError::System { t, source })?;
        let size = largest(before).max(largest(missing));
        for (missing, before) in missing.iter_mut().zip(before) {
            *missing = before - *missing;
        }
        if largest(missing) <= ROUNDING * size {
            return Ok(count);
        }
        let buffers = [&mut *r, &mut *S];
        solve_mass(system, solver, state, (h, damping), buffers, Some(missing))?;
        // That of a multiplier is the impulse of its constraint.
        for (i, dv) in r.iter_mut().enumerate() {
            if system.is_multiplier(i) {
                *dv = 0.0;
            }
        }
        add(&mut state.v, 1.0, r);
        if driven && damping == 0.0 && is_damped(system, state)? {
            add(&mut state.v, -1.0, r);
            (damping, most) = (h, PASSES);
        } else {
            count += 1;
        }
    }
    Ok(most)
}

/// Impulses at most: each leaves ½ (1 − cos θ) of what is missing at a corner of θ.
const IMPULSES: usize = 30;
/// Differences of momentum below this part of the momentum are rounding errors.
const ROUNDING: f64 = 1e-12;

/// Corrections at most of the velocities of what has no mass.
const CORRECTIONS: usize = 30;
/// Corrections below this part of the velocities are rounding errors.
const FINE: f64 = 1e-14;

/// Velocities of what has no mass: where rows of M are zero and their damping is regular the residual
/// is that of a first-order equation r(t, q, q̇) = 0, such as C ż = f of a dashpot or a
/// controller. Newton's method solves it; a step that began with other rates would lose an order.
///
/// Where there is no such solution velocities stay: what has neither mass nor damping is left to the
/// first step.
fn solve_rates<Y: System + ?Sized>(
    system: &mut Y,
    solver: &mut dyn LinearSolver,
    state: &mut State,
    [r, S]: [&mut [f64]; 2],
) -> Result<(), DynamicsError> {
    let State { t, q, v, a, .. } = state;
    let pattern = system.pattern().clone();
    let mut evaluate = |v: &[f64], [K, C, M]: [f64; 3], r: &mut [f64], S: &mut [f64]| {
        let at = Point { t: *t, q, v, a };
        let out = Evaluation::with_tangent(r, Weights { K, C, M }, S);
        let outcome = system.evaluate_accelerations(at, 0.0, out);
        outcome.map_err(|source| DynamicsError::System { t: *t, source })
    };
    evaluate(v, [0.0, 0.0, 1.0], r, S)?;
    let (M, massless) = (S.to_vec(), massless(&pattern, S));
    let mut rates = v.clone();
    for _ in 0..CORRECTIONS {
        evaluate(&rates, [0.0, 1.0, 0.0], r, S)?;
        let both = stand_in(&pattern, &M, S, &massless);
        keep(r, &massless, true);
        if (solver
            .factorise(&both)
            .and_then(|()| solver.solve(Some(&both), r)))
        .is_err()
        {
            return Ok(());
        }
        keep(r, &massless, true);
        add(&mut rates, 1.0, r);
        let size = |x: &[f64]| x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        if size(r) <= FINE * size(&rates) {
            v.copy_from_slice(&rates);
            return Ok(());
        }
    }
    Ok(())
}

/// Which rows of M are zero.
fn massless(pattern: &BlockPattern, M: &[f64]) -> Vec<bool> {
    let mut mass = vec![0.0; pattern.dim()];
    let sizes: Vec<f64> = M.iter().map(|m| m.abs()).collect();
    pattern.multiply_add(1.0, &sizes, &vec![1.0; pattern.dim()], &mut mass);
    mass.iter().map(|m| *m == 0.0).collect()
}

/// M with S in its place between coordinates without mass.
fn stand_in(pattern: &BlockPattern, M: &[f64], S: &[f64], massless: &[bool]) -> Vec<f64> {
    let mut both = M.to_vec();
    for j in 0..pattern.blocks() {
        for (i, range) in pattern.column(j) {
            let rows = pattern.unknowns(i);
            let entries = pattern
                .unknowns(j)
                .flat_map(|c| rows.clone().map(move |r| (r, c)));
            for (k, (r, c)) in range.zip(entries) {
                if massless[r] && massless[c] {
                    both[k] = S[k];
                }
            }
        }
    }
    both
}

/// Clears the entries of what has mass, or of what has none.
fn keep(x: &mut [f64], massless: &[bool], these: bool) {
    let others = x.iter_mut().zip(massless).filter(|(_, m)| **m != these);
    others.for_each(|(x, _)| *x = 0.0);
}

/// Solves M x = b, with `damping` times C beside M, b the residual at the state unless it is given; x is then in
/// `r`. Whether M has an inverse.
///
/// Coordinates without mass make M singular: M + h C + h² K stands in for it then, h the step that
/// will be made, which leaves them in balance with the forces on them to the accuracy of a first
/// step. Where their rows of M are zero it does so in these rows alone, and all other accelerations
/// are exact.
fn solve_mass<Y: System + ?Sized>(
    system: &mut Y,
    solver: &mut dyn LinearSolver,
    state: &State,
    (h, damping): (f64, f64),
    [r, S]: [&mut [f64]; 2],
    b: Option<&[f64]>,
) -> Result<bool, DynamicsError> {
    let t = state.t;
    let mut refused = None;
    let mut M = Vec::new();
    for (C, K) in [(damping, 0.0), (h, h * h)] {
        let at = point(state);
        let out = Evaluation::with_tangent(r, Weights { K, C, M: 1.0 }, S);
        system
            .evaluate_accelerations(at, if b.is_some() { 0.0 } else { h }, out)
            .map_err(|source| DynamicsError::System { t, source })?;
        if let Some(b) = b {
            r.copy_from_slice(b);
        }
        if !M.is_empty() && solve_massive(system.pattern(), solver, &M, r, S).is_ok() {
            return Ok(false);
        }
        match solver.factorise(S).and_then(|()| solver.solve(Some(S), r)) {
            Ok(()) => return Ok(M.is_empty()),
            Err(error) => refused = Some(error),
        }
        M = S.to_vec();
    }
    match refused {
        None => Ok(true),
        Some(source) => Err(DynamicsError::Accelerations {
            t,
            source,
            mechanism: mechanism(system, S),
        }),
    }
}

/// Solves M x = b (b in `r`, then x) with the rows of S in place of those of M that are zero:
/// M₁₁ x₁ = b₁ for what has mass, S₂₂ x₂ = b₂ − S₂₁ x₁ for what has none.
///
/// # Errors
/// [`LinearError`] where there is still no solution, or nothing without mass; `r` is as it was then.
fn solve_massive(
    pattern: &BlockPattern,
    solver: &mut dyn LinearSolver,
    M: &[f64],
    r: &mut [f64],
    S: &[f64],
) -> Result<(), LinearError> {
    let massless = massless(pattern, M);
    let both = stand_in(pattern, M, S, &massless);
    solver.factorise(&both)?;
    let mut x = r.to_vec();
    solver.solve(Some(&both), &mut x)?;
    keep(&mut x, &massless, false);
    let mut rest = r.to_vec();
    pattern.multiply_add(-1.0, S, &x, &mut rest);
    keep(&mut rest, &massless, true);
    solver.solve(Some(&both), &mut rest)?;
    keep(&mut rest, &massless, true);
    for ((r, x), rest) in r.iter_mut().zip(&x).zip(&rest) {
        *r = x + rest;
    }
    Ok(())
}
