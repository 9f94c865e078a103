//! Matrices of all shapes, and solvers for them.

use super::*;
pub use MatrixSymmetry::{General, Symmetric};
pub use pullback_conformance::Random;

/// Shapes of structures: edges between nodes.
pub fn graphs() -> Vec<(&'static str, usize, Vec<[u32; 2]>)> {
    let chain = (1..40).map(|i| [i - 1, i]).collect();
    let tree = (1..60).map(|i| [(i - 1) / 3, i]).collect();
    let ring = (0..30).map(|i| [i, (i + 1) % 30]).collect();
    let star = (1..25).map(|i| [0, i]).collect();
    let mut grid = Vec::new();
    for x in 0..7 {
        for y in 0..8 {
            let here = 8 * x + y;
            if x < 6 {
                grid.push([here, here + 8]);
            }
            if y < 7 {
                grid.push([here, here + 1]);
            }
        }
    }
    let full = (0..9).flat_map(|i| (0..i).map(move |j| [i, j])).collect();
    vec![
        ("chain", 40, chain),
        ("tree", 60, tree),
        ("ring", 30, ring),
        ("star", 25, star),
        ("grid", 56, grid),
        ("full", 9, full),
        ("alone", 1, Vec::new()),
        ("two parts", 4, vec![[0, 2], [1, 3]]),
    ]
}

/// Random numbers between −1 and 1.
pub fn random_numbers(count: usize, random: &mut Random) -> Vec<f64> {
    let mut numbers = vec![0.0; count];
    random.fill(&mut numbers);
    numbers
}

/// Random values, diagonally dominant up to the sign of the diagonal, rows and columns scaled to
/// the given spread of units.
pub fn random_values(
    pattern: &BlockPattern,
    random: &mut Random,
    symmetric: bool,
    indefinite: bool,
    spread: f64,
) -> Vec<f64> {
    let mut matrix = pattern.matrix(&random_numbers(pattern.len(), random));
    if symmetric {
        matrix.fill_lower_triangle_with_upper_triangle();
    }
    let size = |v: &f64| v.abs();
    let sums: Vec<f64> = matrix
        .row_iter()
        .map(|row| 1.0 + row.iter().map(size).sum::<f64>())
        .collect();
    let units: Vec<f64> = sums
        .iter()
        .map(|_| spread.powf(random.range(-1.0, 1.0)))
        .collect();
    filled(pattern, |r, c| {
        let sign = if indefinite && r % 3 == 0 { -1.0 } else { 1.0 };
        let diagonal = if r == c { sign * sums[r] } else { 0.0 };
        (matrix[(r, c)] + diagonal) * units[r] * units[c]
    })
}

/// The values of a matrix with these entries in the blocks of its pattern.
pub fn filled(pattern: &BlockPattern, entry: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let zeros = vec![0.0; pattern.len()];
    pattern
        .triplets(&zeros)
        .map(|(r, c, _)| entry(r, c))
        .collect()
}

/// Number of negative eigenvalues of a symmetric matrix, by nalgebra.
pub fn negative(pattern: &BlockPattern, values: &[f64]) -> Option<usize> {
    let eigenvalues = pattern.matrix(values).symmetric_eigenvalues();
    Some(eigenvalues.iter().filter(|e| **e < 0.0).count())
}

/// A full matrix of scalar nodes, of which the last is eliminated first, and beside them a node of six
/// unknowns coupled to none of them, which makes it a matrix that the block solver is chosen for.
pub fn scalars<const N: usize>(A: [[f64; N]; N]) -> (BlockPattern, Vec<f64>) {
    let sizes = [vec![1; N], vec![6]].concat();
    let pattern = BlockPattern::new(&sizes, [(0..N as u32).collect::<Vec<_>>()]);
    let values = filled(&pattern, |r, c| match r < N {
        true => A[r][c],
        false => f64::from(r == c),
    });
    (pattern, values)
}

/// A solver, and its name.
pub type Named = (&'static str, Box<dyn LinearSolver>);

pub fn solvers(pattern: &BlockPattern, symmetry: MatrixSymmetry) -> Vec<Named> {
    vec![
        ("block", Box::new(BlockLu::new(pattern, symmetry).unwrap())),
        ("faer LU", Box::new(FaerLu::new(pattern).unwrap())),
        (
            "auto",
            Box::new(AutoSolver::new(pattern, symmetry).unwrap()),
        ),
    ]
}

/// The same and one for symmetric matrices alone.
pub fn symmetric_solvers(pattern: &BlockPattern) -> Vec<Named> {
    let mut all = solvers(pattern, Symmetric);
    all.push(("LDLᵀ", Box::new(FaerLdlt::new(pattern).unwrap())));
    all
}

pub fn solve(
    solver: &mut dyn LinearSolver,
    values: &[f64],
    b: &[f64],
) -> Result<Vec<f64>, LinearError> {
    solver.factorise(values)?;
    let mut x = b.to_vec();
    solver.solve(Some(values), &mut x)?;
    Ok(x)
}

/// As [`solve`], in one call.
pub fn solve_at_once(
    solver: &mut dyn LinearSolver,
    values: &[f64],
    b: &[f64],
) -> Result<Vec<f64>, LinearError> {
    let mut x = b.to_vec();
    solver.factorise_and_solve(values, &mut x)?;
    Ok(x)
}
