//! Consistent initial accelerations, M q̈ = r(t, q, q̇, 0), and multipliers.

use super::mass::{keep, zero_rows};
use super::options::check_state;
use super::{DynamicsError, State, Stepper};
use crate::abilities::{energetics, energies, events};
use crate::linear_solver::{LinearSolver, max_abs};
use crate::rounding::rounding_errors;
use crate::vectors::{add, dot};
use pullback_manifold::system::{Evaluation, Point, System, Weights};

/// A state with given coordinates and velocities; the accelerations are computed when a run begins.
///
/// The velocities are those just before `t`. If a prescribed velocity jumps there, the free
/// velocities take the impulse before the first step, as at any later jump. Coordinates must satisfy the equations of
/// multipliers, which a run checks, and velocities their rates.
///
/// # Errors
/// [`DynamicsError::Initial`] if a vector has the wrong length or is not finite. An empty vector
/// means zeros.
pub fn start(system: &dyn System, t: f64, q: &[f64], v: &[f64]) -> Result<State, DynamicsError> {
    let given = |x: &[f64]| match x {
        [] => vec![0.0; system.pattern().dim()],
        x => x.to_vec(),
    };
    let state = State {
        t,
        q: given(q),
        v: given(v),
        a: Vec::new(),
        algorithmic: Vec::new(),
        filtered: Vec::new(),
    };
    check_state(&state, system)?;
    Ok(state)
}

/// Whether dampers dissipate power at a state, more than by rounding errors of velocities.
fn is_damped(system: &mut dyn System, state: &State, h: f64) -> Result<bool, DynamicsError> {
    let energies = energies(system, state.point()).map_err(DynamicsError::at(state.t))?;
    Ok(energies.is_some_and(|now| h * now.dissipated > ROUNDING * now.kinetic))
}

/// Number of solutions with M + h C instead of M behind a jump in a system with dampers.
///
/// A jump excites motions that relax within the step, λh ≫ 1 with λ = C/M, and that no step shows:
/// 4/(λh) of them remains.
const PASSES: usize = 4;
/// The λh above which a motion that relaxes counts as unresolved. The trapezoidal rule takes all of it in the mean of two steps,
/// but alternates about it, by the factor (1 − λh/2)/(1 + λh/2) from step to step.
const RINGING: f64 = 10.0;

/// Largest number of impulses; each leaves ½ (1 − cos θ) of the missing momentum at a corner of θ.
const IMPULSES: usize = 30;
/// Changes of velocities below this part of them, and dissipated energies below this part of the kinetic one, are rounding
/// errors.
const ROUNDING: f64 = 1e-12;

/// Largest number of corrections of massless velocities.
const CORRECTIONS: usize = 30;
/// Corrections below this part of the velocities are rounding errors.
const FINE: f64 = 1e-14;
/// Part of a step in which hardly any damper relaxes.
const MOMENT: f64 = 1e-9;
/// A gap of this many rounding errors is none.
const OPEN: f64 = 1e10;

impl Stepper {
    /// Refuses coordinates at which an equation of multipliers does not hold.
    pub(super) fn check_gaps(
        &mut self,
        system: &mut dyn System,
        state: &State,
    ) -> Result<(), DynamicsError> {
        // Multipliers have no scale.
        if self.inverse_scale.iter().all(|scale| *scale > 0.0) {
            return Ok(());
        }
        let out = Evaluation::with_tangent(&mut self.r, Weights::STATIC, &mut self.S);
        let evaluated = system.evaluate(state.point(), out);
        evaluated.map_err(DynamicsError::at(state.t))?;
        let [sizes, floor] = &mut self.work;
        let [.., rounding] = rounding_errors(system, &self.S, &state.q, [sizes, floor]);
        let mut gaps = system.pattern().coordinates().iter().zip(&self.r);
        match gaps.position(|(c, gap)| c.is_multiplier && gap.abs() > OPEN * rounding) {
            Some(i) => Err(DynamicsError::Initial {
                what: "coordinates",
                problem: format!(
                    "the equation of {} is off by {:.3e}: begin where it holds",
                    system.name(i),
                    self.r[i].abs()
                ),
            }),
            None => Ok(()),
        }
    }

    /// Moves the coordinates to where the equations of multipliers hold, after a jump of prescribed ones within them: by Newton's
    /// method, with the corrections of an impulse.
    ///
    /// # Errors
    /// [`DynamicsError`] if they are not found to hold nearby; the state is then unchanged.
    pub(super) fn close_gaps(
        &mut self,
        system: &mut dyn System,
        state: &mut State,
        h: f64,
    ) -> Result<(), DynamicsError> {
        let multipliers = system.pattern().coordinates().iter();
        let multipliers: Vec<bool> = multipliers.map(|info| info.is_multiplier).collect();
        if !multipliers.contains(&true) {
            return Ok(());
        }
        let (mut before, mut gaps) = (f64::INFINITY, vec![0.0; state.q.len()]);
        let mut there = state.clone();
        loop {
            let evaluated = system.evaluate(there.point(), Evaluation::residual(&mut gaps));
            evaluated.map_err(DynamicsError::at(there.t))?;
            keep(&mut gaps, &multipliers, true);
            let largest = gaps.iter().fold(0.0, |most: f64, gap| most.max(gap.abs()));
            if largest == 0.0 || largest > 0.5 * before {
                break;
            }
            before = largest;
            self.solve_mass(system, &there, (h, 0.0), Some(&gaps))?;
            keep(&mut self.r, &multipliers, false);
            add(&mut there.q, 1.0, &self.r);
        }
        self.check_gaps(system, &there)?;
        state.q = there.q;
        Ok(())
    }

    /// Computes the accelerations of a state, true and algorithmic, its multipliers, and the velocities
    /// of coordinates with damping but no mass.
    ///
    /// The residual is linear in q̈ and λ, so one linear solution suffices:
    /// [M h_xᵀ; h_x 0] (q̈, λ) = (r, −ḧ at q̈ = 0).
    ///
    /// Accelerations that the state already has are corrected, with r and ḧ at these: of a change that dampers would absorb
    /// within a small part of a step hardly anything is taken ([`PASSES`]). Coordinates without mass keep theirs, as only a step
    /// can determine them, unless a prescribed motion `jumps`.
    pub(super) fn accelerate(
        &mut self,
        system: &mut dyn System,
        state: &mut State,
        jumps: bool,
        h: f64,
    ) -> Result<(), DynamicsError> {
        let n = state.q.len();
        // What the algorithmic ones differ by, as they belong to another time, stays.
        add(&mut state.algorithmic, -1.0, &state.filtered);
        // Those before, until the new ones are known.
        state.filtered.clone_from(&state.a);
        if jumps {
            state.a.fill(0.0);
        }
        let multipliers = |i: &usize| system.pattern().coordinates()[*i].is_multiplier;
        let multipliers: Vec<usize> = (0..n).filter(multipliers).collect();
        for &i in &multipliers {
            (state.q[i], state.v[i], state.a[i]) = (0.0, 0.0, 0.0);
        }
        let massive = self.solve_mass(system, state, (h, 0.0), None)?;
        if massive && is_damped(system, state, h)? && !self.lasts(system, state, h) {
            state.a.clone_from(&state.filtered);
            for _ in 0..PASSES {
                self.solve_mass(system, state, (h, h), None)?;
                add(&mut state.a, 1.0, &self.r);
            }
        } else {
            if !massive {
                self.solve_rates(system, state, h)?;
                self.solve_mass(system, state, (h, 0.0), None)?;
            }
            add(&mut state.a, 1.0, &self.r);
        }
        for &i in &multipliers {
            (state.q[i], state.a[i], state.algorithmic[i]) = (self.r[i], 0.0, 0.0);
        }
        state.filtered.clone_from(&state.a);
        add(&mut state.algorithmic, 1.0, &state.a);
        Ok(())
    }

    /// Whether the accelerations of a state with the corrections in `r` last for a good part of a step h: an explicit step with
    /// them leaves forces λh times those at its beginning.
    fn lasts(&mut self, system: &mut dyn System, state: &State, h: f64) -> bool {
        let Some(stage) = self.stages.last_mut() else {
            return true;
        };
        let (there, x) = (&mut stage.state, &mut self.dq[..self.r.len()]);
        x.copy_from_slice(&self.r);
        // The forces at the state, and what is left of them with these accelerations after the step.
        let sizes = [(0.0, 0.0), (h, 1.0)].map(|(h, inertia)| {
            there.t = state.t + h;
            for (i, info) in system.pattern().coordinates().iter().enumerate() {
                let (q, v, a) = (state.q[i], state.v[i], state.a[i] + x[i]);
                [there.q[i], there.v[i], there.a[i]] = match info.is_multiplier {
                    true => [x[i], 0.0, 0.0],
                    false => [q + h * (v + 0.5 * h * a), v + h * a, inertia * a],
                };
            }
            let evaluated = system.evaluate(there.point(), Evaluation::residual(&mut self.r));
            let forces = self.r.iter().zip(system.pattern().coordinates());
            let forces = forces.filter(|(_, info)| !info.is_multiplier);
            evaluated.map(|()| forces.fold(0.0, |most, (r, c)| f64::max(most, r.abs() * c.size)))
        });
        self.r.copy_from_slice(x);
        matches!(sizes, [Ok(forces), Ok(left)] if left <= RINGING * forces)
    }

    /// Applies the impulse at a jump of a prescribed velocity: the momentum of the free coordinates is
    /// continuous, so their velocities jump by M⁻¹ (p₋ − p₊), with p₊ from the new prescribed and the
    /// old free velocities. At a change of segment this is repeated until p equals
    /// [`Events::kept_momentum`](pullback_manifold::system::Events::kept_momentum). Returns the number of impulses.
    pub(super) fn apply_impulse(
        &mut self,
        system: &mut dyn System,
        state: &mut State,
        (before, missing): (&[f64], &mut [f64]),
        prescribed: bool,
        h: f64,
    ) -> Result<usize, DynamicsError> {
        let (mut damping, mut most) = (0.0, if prescribed { 1 } else { IMPULSES });
        let mut count = 0;
        while count < most {
            let at = state.point();
            let known = match prescribed {
                true => energetics(system).momentum(at, missing),
                false => events(system).kept_momentum(Some(at), missing),
            };
            known.map_err(DynamicsError::at(state.t))?;
            for (missing, before) in missing.iter_mut().zip(before) {
                *missing = before - *missing;
            }
            self.solve_mass(system, state, (h, damping), Some(missing))?;
            // Twice the kinetic energies of the change and of the motion.
            let (mut change, mut whole) = (0.0, 0.0);
            for (i, dv) in self.r.iter_mut().enumerate() {
                if system.pattern().coordinates()[i].is_multiplier {
                    // This is the impulse of its constraint.
                    change -= std::mem::take(dv) * missing[i];
                } else {
                    change += *dv * missing[i];
                    whole += state.v[i] * before[i];
                }
            }
            if change.abs() <= ROUNDING * ROUNDING * whole.abs() {
                return Ok(count);
            }
            if prescribed && damping == 0.0 && self.is_absorbed(system, state, missing, h)? {
                (damping, most) = (h, PASSES);
            } else {
                add(&mut state.v, 1.0, &self.r);
                count += 1;
            }
        }
        Ok(most)
    }

    /// Whether dampers take much more energy within a step h of the velocities in `r` than the impulse that causes them.
    fn is_absorbed(
        &mut self,
        system: &mut dyn System,
        state: &State,
        impulse: &[f64],
        h: f64,
    ) -> Result<bool, DynamicsError> {
        let (mut v, dv) = (state.v.clone(), self.r.clone());
        add(&mut v, 1.0, &dv);
        self.evaluate_at(system, state, &v, Weights::DAMPING, 0.0)?;
        let mut taken = vec![0.0; dv.len()];
        system.pattern().multiply_add(h, &self.S, &dv, &mut taken);
        self.r = dv;
        Ok(dot(&taken, &self.r) > RINGING * dot(impulse, &self.r))
    }

    /// Solves for velocities with damping but no mass: along directions in which M is zero, but not C, the residual is a
    /// first-order equation r(t, q, q̇) = 0, such as C ż = f of a dashpot or a controller, or that of two dampers in series. A
    /// step from other rates would lose an order.
    ///
    /// An implicit step of a moment τ, (M + τ C) x = r, changes them by τ x. What it changes of all others,
    /// τ (M + τ C)⁻¹ M x, is taken back.
    /// Coordinates with neither mass nor damping are left to the first step: a little of K holds them here. Without a
    /// solution the velocities stay.
    fn solve_rates(
        &mut self,
        system: &mut dyn System,
        state: &mut State,
        h: f64,
    ) -> Result<(), DynamicsError> {
        let mut rates = state.v.clone();
        self.evaluate_at(system, state, &rates, Weights::DAMPING, 0.0)?;
        let undamped = zero_rows(system.pattern(), &self.S);
        self.evaluate_at(system, state, &rates, Weights::MASS, 0.0)?;
        let (M, mut left) = (self.S.clone(), zero_rows(system.pattern(), &self.S));
        left.iter_mut()
            .zip(undamped)
            .for_each(|(left, u)| *left &= u);
        let moment = MOMENT * h;
        let weights = Weights {
            K: moment * moment,
            C: moment,
            M: 1.0,
        };
        for _ in 0..CORRECTIONS {
            self.evaluate_at(system, state, &rates, weights, 0.0)?;
            keep(&mut self.r, &left, false);
            if (self.solver.factorise_and_solve(&self.S, &mut self.r)).is_err() {
                return Ok(());
            }
            let mut others = vec![0.0; rates.len()];
            (system.pattern()).multiply_add(1.0, &M, &self.r, &mut others);
            if self.solver.solve(Some(&self.S), &mut others).is_err() {
                return Ok(());
            }
            add(&mut self.r, -1.0, &others);
            keep(&mut self.r, &left, false);
            add(&mut rates, moment, &self.r);
            if moment * max_abs(&self.r) <= FINE * max_abs(&rates) {
                state.v = rates;
                return Ok(());
            }
        }
        Ok(())
    }

    /// Residual and tangent at a state with other velocities; see [`Evaluation::accelerations`].
    pub(super) fn evaluate_at(
        &mut self,
        system: &mut dyn System,
        state: &State,
        v: &[f64],
        weights: Weights,
        h: f64,
    ) -> Result<(), DynamicsError> {
        let out = Evaluation {
            accelerations: Some(h),
            ..Evaluation::with_tangent(&mut self.r, weights, &mut self.S)
        };
        let at = Point { v, ..state.point() };
        let evaluated = system.evaluate(at, out);
        evaluated.map_err(DynamicsError::at(state.t))
    }
}
