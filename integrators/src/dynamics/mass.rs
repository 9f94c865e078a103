//! Solutions with the mass matrix, in which coordinates may have no mass.

use super::{DynamicsError, State, Stepper};
use crate::failure::find_mechanism;
use crate::linear_solver::{LinearError, LinearSolver};
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::{Evaluation, System, SystemError, Weights};

impl Stepper {
    /// Replaces the accelerations and multipliers of the new state by those that follow from its coordinates and velocities,
    /// [M h_xᵀ; h_x 0] (δq̈, δλ) = (0, −ḧ). Those of the step satisfy h = 0 at its end instead: a change of the step size or
    /// of a chart disturbs them by O(h). They stay where coordinates without mass leave no solution.
    pub(super) fn determine_multipliers(
        &mut self,
        system: &mut dyn System,
    ) -> Result<(), SystemError> {
        if self.inverse_scale.iter().all(|scale| *scale > 0.0) {
            return Ok(());
        }
        (self.evaluations, self.factorisations) = (self.evaluations + 1, self.factorisations + 1);
        let (next, change) = (&mut self.next, &mut self.dq[..self.r.len()]);
        let out = Evaluation {
            accelerations: Some(0.0),
            ..Evaluation::with_tangent(change, Weights::MASS, &mut self.S)
        };
        system.evaluate(next.point(), out)?;
        if (self.solver.factorise_and_solve(&self.S, change)).is_ok() {
            for (i, change) in change.iter().enumerate() {
                match self.inverse_scale[i] {
                    0.0 => next.q[i] += change,
                    _ => next.a[i] += change,
                }
            }
        }
        Ok(())
    }

    /// Solves M x = b with `damping` times C added to M, where b is the residual at the state
    /// unless given; x is returned in `r`. Whether M has an inverse.
    ///
    /// If coordinates without mass make M singular, it is replaced by M + h C + h² K with the next
    /// step h, which balances their forces to the accuracy of a first step. If their rows of M are
    /// zero, only these rows are replaced, and all other accelerations are exact.
    pub(super) fn solve_mass(
        &mut self,
        system: &mut dyn System,
        state: &State,
        (h, damping): (f64, f64),
        b: Option<&[f64]>,
    ) -> Result<bool, DynamicsError> {
        let step = if b.is_some() { 0.0 } else { h };
        let mut singular: Option<Vec<f64>> = None;
        loop {
            let (C, K) = match singular {
                None => (damping, 0.0),
                Some(_) => (h, h * h),
            };
            self.evaluate_at(system, state, &state.v, Weights { K, C, M: 1.0 }, step)?;
            if let Some(b) = b {
                self.r.copy_from_slice(b);
            }
            if let Some(M) = &singular
                && self.solve_massive(system, M).is_ok()
            {
                return Ok(false);
            }
            match self.solver.factorise_and_solve(&self.S, &mut self.r) {
                Ok(()) => return Ok(singular.is_none()),
                Err(LinearError::NonFinite { unknown, .. }) => {
                    let what = system.name(unknown);
                    return Err(DynamicsError::at(state.t)(SystemError::NotFinite { what }));
                }
                Err(_) if singular.is_none() => singular = Some(self.S.clone()),
                Err(source) => {
                    return Err(DynamicsError::Accelerations {
                        t: state.t,
                        source,
                        mechanism: find_mechanism(system, &self.S),
                    });
                }
            }
        }
    }

    /// Solves M x = b (b in `r`, then x) with the zero rows of M replaced by those of S: M₁₁ x₁ = b₁
    /// for coordinates with mass, S₂₂ x₂ = b₂ − S₂₁ x₁ for those without.
    ///
    /// # Errors
    /// [`LinearError`] if there is still no solution, or no coordinate without mass; `r` is then
    /// unchanged.
    fn solve_massive(&mut self, system: &dyn System, M: &[f64]) -> Result<(), LinearError> {
        let (pattern, S) = (system.pattern(), &self.S);
        let massless = zero_rows(pattern, M);
        let both = stand_in(pattern, M, S, &massless);
        self.solver.factorise(&both)?;
        let mut x = self.r.to_vec();
        self.solver.solve(Some(&both), &mut x)?;
        keep(&mut x, &massless, false);
        let mut rest = self.r.to_vec();
        pattern.multiply_add(-1.0, S, &x, &mut rest);
        keep(&mut rest, &massless, true);
        self.solver.solve(Some(&both), &mut rest)?;
        keep(&mut rest, &massless, true);
        for ((r, x), rest) in self.r.iter_mut().zip(&x).zip(&rest) {
            *r = x + rest;
        }
        Ok(())
    }
}

/// Which rows of a matrix are zero.
pub(super) fn zero_rows(pattern: &BlockPattern, values: &[f64]) -> Vec<bool> {
    let mut zero = vec![true; pattern.dim()];
    for (r, _, value) in pattern.triplets(values) {
        zero[r] &= value == 0.0;
    }
    zero
}

/// M with the entries of S between coordinates without mass.
fn stand_in(pattern: &BlockPattern, M: &[f64], S: &[f64], massless: &[bool]) -> Vec<f64> {
    let mut both = M.to_vec();
    for (k, (r, c, entry)) in pattern.triplets(S).enumerate() {
        if massless[r] && massless[c] {
            both[k] = entry;
        }
    }
    both
}

/// Clears the entries of coordinates with mass, or of those without.
pub(super) fn keep(x: &mut [f64], massless: &[bool], these: bool) {
    let others = x.iter_mut().zip(massless).filter(|(_, m)| **m != these);
    others.for_each(|(x, _)| *x = 0.0);
}
