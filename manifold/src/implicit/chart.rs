//! The choice of the coordinates q, and the matrix A⁻¹.

#![allow(non_snake_case)]

use super::factor::{Pivoted, inverse, pivoted};
use super::{Choice, Implicit, ImplicitError, names};
use nalgebra::{SMatrix, SVector};

/// Equations whose gradients add less than this to the span of the others depend on them; a
/// condition number beyond its inverse is singular.
pub(super) const RANK: f64 = 1e-8;

/// Selection of the coordinates q and of the independent equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Chart<const D: usize, const X: usize, const M: usize> {
    /// q = Lᵀ (x − x_ref).
    pub L: SMatrix<f64, X, D>,
    /// The selected coordinates if L picks some.
    pub independent: Option<[usize; D]>,
    /// Equations in use; the others follow from them.
    pub used: [bool; M],
}

/// A⁻¹ = [B | P], with zero columns of P for equations that are not in use.
pub(super) struct Inverse<const D: usize, const X: usize, const M: usize> {
    pub B: SMatrix<f64, X, D>,
    pub P: SMatrix<f64, X, M>,
    /// Condition number of A with rows of unit length and coordinates over their sizes.
    pub condition: f64,
}

/// The chart of selected coordinates; `None` if one is named twice or does not exist.
pub(super) fn split<const D: usize, const X: usize, const M: usize>(
    independent: [usize; D],
    used: [bool; M],
) -> Option<Chart<D, X, M>> {
    let mut L = SMatrix::zeros();
    for (j, &k) in independent.iter().enumerate() {
        if k >= X || independent[..j].contains(&k) {
            return None;
        }
        L[(k, j)] = 1.0;
    }
    Some(Chart {
        L,
        independent: Some(independent),
        used,
    })
}

/// Length of row i of h_x with coordinates over their sizes.
pub(super) fn row_size<H, const X: usize, const M: usize>(
    constraint: &H,
    J: &SMatrix<f64, M, X>,
    i: usize,
) -> f64
where
    H: Implicit<X, M>,
{
    let squares = (0..X).map(|k| (J[(i, k)] * constraint.size(k)).powi(2));
    squares.sum::<f64>().sqrt()
}

/// Size of each equation: the length of its row, or its earlier maximum. A shrinking row indicates
/// a singular configuration, which scaling must not hide; a row that vanishes beside the others has
/// no size of its own.
pub(super) fn sizes<H, const X: usize, const M: usize>(
    constraint: &H,
    J: &SMatrix<f64, M, X>,
    before: &[f64; M],
) -> [f64; M]
where
    H: Implicit<X, M>,
{
    let now: [f64; M] = std::array::from_fn(|i| row_size(constraint, J, i).max(before[i]));
    let largest = now.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    now.map(|size| if size > RANK * largest { size } else { largest })
}

/// h_x with equations and coordinates over their sizes.
pub(super) fn scaled<H, const X: usize, const M: usize>(
    constraint: &H,
    J: &SMatrix<f64, M, X>,
    sizes: &[f64; M],
) -> SMatrix<f64, M, X>
where
    H: Implicit<X, M>,
{
    SMatrix::from_fn(|i, k| J[(i, k)] * constraint.size(k) / sizes[i])
}

/// A⁻¹ in a chart; `None` where A is singular.
pub(super) fn invert<H, const D: usize, const X: usize, const M: usize>(
    constraint: &H,
    chart: &Chart<D, X, M>,
    J: &SMatrix<f64, M, X>,
    sizes: &[f64; M],
) -> Option<Inverse<D, X, M>>
where
    H: Implicit<X, M>,
{
    let mut A = SMatrix::<f64, X, X>::zeros();
    let mut length = SVector::<f64, X>::zeros();
    let used = (0..M).filter(|&i| chart.used[i]);
    for row in 0..D {
        A.set_row(row, &chart.L.column(row).transpose());
    }
    for (row, i) in used.clone().enumerate() {
        A.set_row(D + row, &J.row(i));
    }
    for row in 0..D {
        let squares = (0..X).map(|k| (A[(row, k)] * constraint.size(k)).powi(2));
        length[row] = squares.sum::<f64>().sqrt();
    }
    for (row, i) in used.clone().enumerate() {
        length[D + row] = sizes[i];
    }
    for row in 0..X {
        for k in 0..X {
            A[(row, k)] *= constraint.size(k) / length[row];
        }
    }
    let mut out = inverse(&A)?;
    let condition = A.norm() * out.norm();
    for k in 0..X {
        for row in 0..X {
            out[(k, row)] *= constraint.size(k) / length[row];
        }
    }
    let mut P = SMatrix::<f64, X, M>::zeros();
    for (row, i) in used.enumerate() {
        P.set_column(i, &out.column(D + row));
    }
    condition.is_finite().then(|| Inverse {
        B: out.fixed_columns::<D>(0).into_owned(),
        P,
        condition,
    })
}

/// The best equations and coordinates at a point with the derivative J = h_x, and A⁻¹ for them.
pub(super) fn best<H, const D: usize, const X: usize, const M: usize>(
    constraint: &H,
    J: &SMatrix<f64, M, X>,
    sizes: &[f64; M],
    choice: Choice,
) -> Option<(Chart<D, X, M>, Inverse<D, X, M>)>
where
    H: Implicit<X, M>,
{
    let rows = scaled(constraint, J, sizes);
    let equations = pivoted(&rows.transpose());
    let mut used = [false; M];
    for &i in &equations.order[..X - D] {
        used[i] = true;
    }
    let chart = match choice {
        Choice::Split | Choice::Fixed => {
            let rows =
                SMatrix::<f64, M, X>::from_fn(|i, k| if used[i] { rows[(i, k)] } else { 0.0 });
            let columns = pivoted(&rows);
            let mut rest = [0; D];
            rest.copy_from_slice(&columns.order[X - D..]);
            rest.sort_unstable();
            split(rest, used)?
        }
        Choice::Tangent => Chart {
            L: complement(constraint, &equations),
            independent: None,
            used,
        },
    };
    let inverse = invert(constraint, &chart, J, sizes)?;
    (inverse.condition * RANK < 1.0).then_some((chart, inverse))
}

/// Orthonormal directions across the gradients, of coordinates over their sizes.
fn complement<H, const D: usize, const X: usize, const M: usize>(
    constraint: &H,
    equations: &Pivoted<X, M>,
) -> SMatrix<f64, X, D>
where
    H: Implicit<X, M>,
{
    let mut projector = SMatrix::<f64, X, X>::identity();
    for k in 0..X - D {
        let n = equations.basis.column(k).into_owned();
        projector -= n * n.transpose();
    }
    let across = pivoted(&projector);
    SMatrix::from_fn(|k, j| across.basis[(k, j)] / constraint.size(k))
}

pub(super) fn singular<H, const D: usize, const X: usize, const M: usize>(
    constraint: &H,
    J: &SMatrix<f64, M, X>,
    sizes: &[f64; M],
) -> ImplicitError
where
    H: Implicit<X, M>,
{
    let rank = pivoted(&scaled(constraint, J, sizes).transpose()).rank(RANK);
    let (equations, coordinates) = names::dependences(constraint, J, sizes, X - D);
    ImplicitError::Singular {
        equations,
        coordinates,
        left: X - rank,
        expected: D,
    }
}
