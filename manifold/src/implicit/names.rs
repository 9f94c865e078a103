//! Messages: which equations depend on which, and which coordinates they leave undetermined.

#![allow(non_snake_case)]

use super::Implicit;
use super::chart::{RANK, scaled};
use super::factor::pivoted;
use nalgebra::SMatrix;

/// Coefficients and components below this are not named.
const SMALL: f64 = 1e-4;

/// Names joined as in a sentence.
pub(super) fn list(names: &[String]) -> String {
    match names {
        [] => "none".to_owned(),
        [one] => one.clone(),
        [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
    }
}

/// Names of the equations on which equation `i` depends.
pub(super) fn others<H, const X: usize, const M: usize>(
    constraint: &H,
    J: &SMatrix<f64, M, X>,
    sizes: &[f64; M],
    i: usize,
) -> String
where
    H: Implicit<X, M>,
{
    let rows = scaled(constraint, J, sizes);
    // The gradient of i in terms of the others: triangular elimination along their basis.
    let found = pivoted(&SMatrix::<f64, X, M>::from_fn(|k, j| {
        if j == i { 0.0 } else { rows[(j, k)] }
    }));
    let rank = found.rank(RANK);
    let mut left = rows.row(i).transpose();
    let mut names = Vec::new();
    for k in (0..rank).rev() {
        let equation = found.order[k];
        let row = rows.row(equation).transpose();
        let direction = found.basis.column(k);
        let factor = left.dot(&direction) / row.dot(&direction);
        left -= row * factor;
        if factor.abs() > SMALL {
            names.push((equation, constraint.equation(equation)));
        }
    }
    names.sort();
    let names: Vec<String> = names.into_iter().map(|(_, name)| name).collect();
    if names.is_empty() {
        "no other equation".to_owned()
    } else {
        list(&names)
    }
}

/// Equations beyond the rank (the weakest if all `expected` are independent), each with those on
/// which it depends, and the coordinates that can move while the equations hold.
pub(super) fn dependences<H, const X: usize, const M: usize>(
    constraint: &H,
    J: &SMatrix<f64, M, X>,
    sizes: &[f64; M],
    expected: usize,
) -> (String, String)
where
    H: Implicit<X, M>,
{
    let rows = scaled(constraint, J, sizes);
    let equations = pivoted(&rows.transpose());
    let rank = equations.rank(RANK);
    let mut weak: Vec<usize> = equations.order[rank.min(M - 1)..].to_vec();
    weak.sort_unstable();
    let dependent: Vec<String> = weak
        .iter()
        .map(|&i| {
            let others = others(constraint, J, sizes, i);
            format!("{} depends on {others}", constraint.equation(i))
        })
        .collect();
    // There are more directions across the gradients than expected; the new ones cannot be told
    // from the others.
    let mut projector = SMatrix::<f64, X, X>::identity();
    for k in 0..rank.min(expected) {
        let n = equations.basis.column(k).into_owned();
        projector -= n * n.transpose();
    }
    let moving: Vec<String> = (0..X)
        .filter(|&k| projector[(k, k)] > SMALL)
        .map(|k| constraint.coordinate(k))
        .collect();
    (list(&dependent), list(&moving))
}
