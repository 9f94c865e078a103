//! The tangent with one coordinate held.

use super::PathDirection;
use crate::failure::Cause;
use crate::linear_solver::{AutoSolver, LinearSolver};
use crate::statics::newton::Newton;
use crate::vectors::add;
use pullback_manifold::system::System;

/// The tangent with a spring at the held coordinate k, factorised, and its results.
pub(super) struct Held {
    k: usize,
    /// Index of the diagonal entry of k among the values.
    entry: usize,
    /// Least stiffness of the spring; g does not depend on it.
    spring: f64,
    values: Vec<f64>,
    /// Displacement of k under a unit force at k, of the tangent with the spring.
    compliance: f64,
    /// ψ, with ψ_k = 1.
    pub psi: PathDirection,
    /// Less the stiffness against a force at k alone.
    pub g: f64,
}

impl Held {
    /// For the coordinate k, with a spring as stiff as the tangent that was evaluated last is there.
    pub fn at(k: usize, newton: &Newton, system: &dyn System) -> Option<Self> {
        let entry = system.pattern().diagonal().nth(k)?;
        let spring = newton.S[entry].abs();
        Some(Self {
            k,
            entry,
            spring: if spring > 0.0 { spring } else { 1.0 },
            values: newton.S.clone(),
            compliance: 0.0,
            psi: PathDirection {
                dq: vec![0.0; newton.r.len()],
                dt: 0.0,
            },
            g: 0.0,
        })
    }

    /// Factorises the tangent that was evaluated last.
    pub fn update(&mut self, newton: &mut Newton) -> Result<(), Cause> {
        self.values.copy_from_slice(&newton.S);
        let spring = self.spring.max(2.0 * newton.S[self.entry].abs());
        self.values[self.entry] += spring;
        newton.summary.factorisations += 1;
        let psi = &mut self.psi.dq;
        psi.fill(0.0);
        psi[self.k] = 1.0;
        let solved = newton.solver.factorise_and_solve(&self.values, psi);
        solved.map_err(Cause::linear)?;
        self.compliance = psi[self.k];
        self.g = spring - 1.0 / self.compliance;
        psi.iter_mut().for_each(|x| *x /= self.compliance);
        Ok(())
    }

    /// Displacements under a force with k held, and the reaction there, φᵀ force.
    pub fn solve(
        &self,
        solver: &mut AutoSolver,
        force: &[f64],
        dt: f64,
    ) -> Result<(PathDirection, f64), Cause> {
        let mut dq = force.to_vec();
        let solved = solver.solve(Some(&self.values), &mut dq);
        solved.map_err(Cause::linear)?;
        let at_k = dq[self.k];
        add(&mut dq, -at_k, &self.psi.dq);
        Ok((PathDirection { dq, dt }, at_k / self.compliance))
    }
}
