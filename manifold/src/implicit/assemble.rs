//! The first configuration: h(t, x) = 0 from a guess, before coordinates q exist.

#![allow(non_snake_case)]

use super::chart::{RANK, row_size, scaled, sizes};
use super::closed::aside;
use super::factor::pivoted;
use super::solve::{CONSISTENT, CONVERGED, ROUNDING};
use super::{Equations, Implicit, ImplicitError, names};
use crate::map::derived;
use nalgebra::{SMatrix, SVector};

/// Iterations at most.
const ITERATIONS: usize = 200;

/// The configuration near `guess` by Newton's method with steps of least length (of coordinates
/// over their sizes), at most 1 long, on the X − D equations that are most independent.
pub(super) fn assemble<H, const D: usize, const X: usize, const M: usize>(
    constraint: &H,
    t: f64,
    guess: SVector<f64, X>,
) -> Result<SVector<f64, X>, ImplicitError>
where
    H: Implicit<X, M>,
{
    let residual = Equations(constraint);
    let mut x = guess;
    let mut before = f64::INFINITY;
    for iteration in 0..ITERATIONS {
        let at = derived::tangent(&residual, t, &x);
        if let Some(i) =
            (0..M).find(|&i| !at.x[i].is_finite() || !row_size(constraint, &at.B, i).is_finite())
        {
            return Err(ImplicitError::NotFinite {
                equation: constraint.equation(i),
            });
        }
        let sizes = sizes(constraint, &at.B, &[0.0; M]);
        let rows = scaled(constraint, &at.B, &sizes);
        let found = pivoted(&rows.transpose());
        let count = found.rank(RANK).min(X - D);
        // With the basis Q of their gradients the equations are triangular in y, ξ = Q y.
        let mut step = SVector::<f64, X>::zeros();
        for k in 0..count {
            let i = found.order[k];
            let row = rows.row(i);
            let h = at.x[i] / sizes[i];
            let direction = found.basis.column(k);
            let y = -(h + row.transpose().dot(&step)) / row.transpose().dot(&direction);
            step += direction * y;
        }
        let size = step.norm();
        step *= 1.0 / size.max(1.0);
        for k in 0..X {
            x[k] += step[k] * constraint.size(k);
        }
        if size <= CONVERGED || (size <= ROUNDING && size > 0.5 * before) {
            return check::<H, D, X, M>(constraint, t, x);
        }
        // If the other equations contradict each other, nothing converges.
        if iteration + 1 == ITERATIONS {
            let i = at.x.iamax();
            return Err(ImplicitError::NotAssembled {
                equation: constraint.equation(i),
                residual: at.x[i],
                iterations: ITERATIONS,
            });
        }
        before = size;
    }
    Ok(x)
}

/// Whether all equations hold at x, and leave D coordinates free.
fn check<H, const D: usize, const X: usize, const M: usize>(
    constraint: &H,
    t: f64,
    x: SVector<f64, X>,
) -> Result<SVector<f64, X>, ImplicitError>
where
    H: Implicit<X, M>,
{
    let at = derived::tangent(&Equations(constraint), t, &x);
    let J: SMatrix<f64, M, X> = at.B;
    let sizes = sizes(constraint, &J, &[0.0; M]);
    let found = pivoted(&scaled(constraint, &J, &sizes).transpose());
    let rank = found.rank(RANK);
    if rank > X - D {
        return Err(ImplicitError::TooManyEquations {
            equation: constraint.equation(found.order[rank - 1]),
            rank,
            left: X - rank,
            coordinates: X,
            expected: D,
        });
    }
    for i in 0..M {
        if at.x[i].abs() > CONSISTENT * sizes[i] {
            if row_size(constraint, &J, i) <= RANK * sizes[i] {
                return Err(ImplicitError::Flat {
                    equation: constraint.equation(i),
                    residual: at.x[i],
                });
            }
            return Err(ImplicitError::Inconsistent {
                equation: constraint.equation(i),
                others: names::others(constraint, &J, &sizes, i),
                residual: at.x[i],
            });
        }
    }
    Ok(x)
}

/// Distance (relative to sizes) at which gradients are evaluated beside a solution.
const ASIDE: f64 = 1e-3;
/// A gradient smaller than this relative to its value beside the solution vanishes there: if an
/// equation only touches zero, Newton's method ends about 1e-10 away.
const VANISHES: f64 = 1e-5;

/// Equations with a gradient J that vanishes at a solution x and does not beside it.
pub(super) fn touching<H, const X: usize, const M: usize>(
    constraint: &H,
    t: f64,
    x: &SVector<f64, X>,
    J: &SMatrix<f64, M, X>,
) -> [bool; M]
where
    H: Implicit<X, M>,
{
    let beside = SVector::from_fn(|k, _| x[k] + ASIDE * aside(k) * constraint.size(k));
    let there = derived::tangent(&Equations(constraint), t, &beside).B;
    std::array::from_fn(|i| {
        let [now, there] = [J, &there].map(|J| row_size(constraint, J, i));
        now < VANISHES * there
    })
}
