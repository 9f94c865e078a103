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
use pullback_manifold::system::System;

/// Number of unstable directions at the state evaluated and factorised last.
///
/// `None` if the tangent is not symmetric, or the solver does not provide it.
pub(super) fn unstable(
    newton: &Newton,
    solver: &mut dyn LinearSolver,
    system: &dyn System,
) -> Option<usize> {
    if !system.is_symmetric() {
        return None;
    }
    let negative = solver.negative_pivots(&newton.S)?;
    let pattern = system.pattern();
    let mut equations = 0;
    for block in 0..pattern.blocks() {
        let n = pattern.size(block);
        let start = pattern.find(block, block)?;
        for (k, unknown) in pattern.unknowns(block).enumerate() {
            // A multiplier with a redundant equation has a diagonal entry and no others.
            let enforced = newton.S[start + k * (n + 1)] == 0.0;
            equations += usize::from(enforced && system.coordinate_info(unknown).is_multiplier);
        }
    }
    negative.checked_sub(equations)
}
