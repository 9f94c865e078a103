//! Number of unstable directions of an equilibrium.
//!
//! The tangent K of a conservative system is the second derivative of the total potential, whose
//! minima are the stable equilibria: each negative eigenvalue is a direction in which the potential
//! falls. At an equilibrium their number does not depend on the coordinates. A Lagrange multiplier
//! adds a negative eigenvalue to those of K on the directions that its equation leaves free (saddle
//! points: Nocedal & Wright 2006, Numerical Optimization, theorem 16.3), so the number of equations
//! is subtracted.

use super::Problem;
use super::newton::Newton;

impl Newton {
    /// Number of unstable directions at the state evaluated and factorised last.
    ///
    /// `None` if the tangent is not symmetric, or the solver does not provide it.
    pub(super) fn unstable(&self, problem: &mut Problem<'_>) -> Option<usize> {
        let system = &*problem.system;
        if !system.is_symmetric() {
            return None;
        }
        let negative = problem.solver.negative_pivots(&self.S)?;
        let diagonal = system.pattern().diagonal().enumerate();
        // A multiplier with a redundant equation has a diagonal entry and no others.
        let enforced =
            |&(i, k): &(usize, usize)| self.S[k] == 0.0 && system.coordinate_info(i).is_multiplier;
        let equations = diagonal.filter(enforced).count();
        negative.checked_sub(equations)
    }
}
