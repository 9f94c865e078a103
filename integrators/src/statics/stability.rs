//! Number of unstable directions of an equilibrium.
//!
//! The tangent K of a conservative system is the second derivative of the total potential, whose
//! minima are the stable equilibria: each negative eigenvalue is a direction in which the potential
//! falls. At an equilibrium their number does not depend on the coordinates. A Lagrange multiplier
//! adds a negative eigenvalue to those of K on the directions that its equation leaves free (saddle
//! points: Nocedal & Wright 2006, Numerical Optimization, theorem 16.3), so the number of equations
//! is subtracted.

use super::newton::Newton;
use crate::linear_solver::LinearSolver;
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::System;

impl Newton {
    /// Number of unstable directions at the state evaluated and factorised last.
    ///
    /// `None` if the tangent is not symmetric, or the solver does not provide it.
    pub(super) fn unstable(&mut self, system: &dyn System) -> Option<usize> {
        if !system.is_symmetric() {
            return None;
        }
        let negative = self.solver.negative_pivots(&self.S)?;
        negative.checked_sub(enforced_equations(system.pattern(), &self.S))
    }
}

/// Number of equations with multipliers in a tangent.
pub(crate) fn enforced_equations(pattern: &BlockPattern, S: &[f64]) -> usize {
    let is_multiplier = |i: usize| pattern.coordinates()[i].is_multiplier;
    // A multiplier with a redundant equation has a diagonal entry and no others.
    let enforced = |&(i, k): &(usize, usize)| S[k] == 0.0 && is_multiplier(i);
    pattern.diagonal().enumerate().filter(enforced).count()
}
