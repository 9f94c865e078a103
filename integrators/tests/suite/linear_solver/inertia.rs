//! Negative pivots against the eigenvalues of a dense matrix (nalgebra): Sylvester's law.

#![allow(clippy::unwrap_used)]

use crate::support::linear_solver::{General, Symmetric, analysed, write};
use nalgebra::DMatrix;
use pullback_integrators::linear_solver::{
    AutoSolver, BlockLu, FaerCholesky, FaerLu, LinearSolver,
};
use pullback_manifold::sparse::BlockPattern;

/// A number in (-1, 1) for each pair, the same for (i, j) and (j, i).
fn hashed(i: usize, j: usize, seed: u64) -> f64 {
    let mut x = (i.min(j) as u64 * 1_000_003 + i.max(j) as u64) ^ seed.wrapping_mul(0x9e37_79b9);
    for _ in 0..4 {
        x = x
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        x ^= x >> 29;
    }
    (x >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// A symmetric matrix, blocks of the pattern filled by `entry`, beside its dense form.
fn matrix(pattern: &BlockPattern, entry: impl Fn(usize, usize) -> f64) -> (Vec<f64>, DMatrix<f64>) {
    let mut values = vec![0.0; pattern.len()];
    write(pattern, &mut values, entry);
    let dense = pattern.matrix(&values);
    (values, dense)
}

fn negative(dense: DMatrix<f64>) -> usize {
    let eigenvalues = dense.symmetric_eigenvalues();
    eigenvalues.iter().filter(|e| **e < 0.0).count()
}

fn chain(blocks: u32) -> Vec<[u32; 2]> {
    (1..blocks).map(|i| [i - 1, i]).collect()
}

fn full(blocks: u32) -> Vec<[u32; 2]> {
    (0..blocks)
        .flat_map(|i| (0..i).map(move |j| [i, j]))
        .collect()
}

#[test]
fn the_signs_of_pivots_are_those_of_eigenvalues() {
    for (edges, blocks) in [(chain(20), 20_u32), (full(9), 9), (Vec::new(), 3)] {
        for size in [1, 2, 3, 4, 6, 9] {
            let pattern = BlockPattern::new(&vec![size; blocks as usize], &edges);
            for indefinite in [false, true] {
                // Dominant diagonals, of either sign: no solver needs to interchange rows.
                let heavy = 2.0 * pattern.dim() as f64;
                let (values, dense) = matrix(&pattern, |i, j| {
                    let sign = if indefinite && i % 3 == 0 { -1.0 } else { 1.0 };
                    hashed(i, j, 7) + if i == j { sign * heavy } else { 0.0 }
                });
                let expected = negative(dense);
                assert_eq!(expected > 0, indefinite);
                let solvers: [(&str, Box<dyn LinearSolver>); 3] = [
                    ("block", Box::new(BlockLu::new())),
                    ("auto", Box::new(AutoSolver::new())),
                    ("cholesky", Box::new(FaerCholesky::new())),
                ];
                for (name, mut solver) in solvers {
                    solver.analyse(&pattern, Symmetric).unwrap();
                    assert_eq!(solver.negative_pivots(&values), None, "{name}: no factors");
                    solver.factorise(&values).unwrap();
                    let count = solver.negative_pivots(&values);
                    assert_eq!(count, Some(expected), "{name}, {blocks} blocks of {size}");
                }
            }
        }
    }
}

#[test]
fn interchanges_inside_a_block_keep_the_count() {
    // Saddle points: half of the unknowns of each block have no diagonal, so that rows are
    // interchanged, and as many eigenvalues are negative as there are such unknowns.
    let mut counts = Vec::new();
    for size in [2, 3, 4, 6, 8] {
        for seed in 0..20 {
            let pattern = BlockPattern::new(&[size; 12], chain(12));
            let (values, dense) = matrix(&pattern, |i, j| {
                let multiplier = |k: usize| k % size >= size / 2;
                let weight = if i / size == j / size { 1.0 } else { 0.02 };
                match (multiplier(i), multiplier(j)) {
                    (true, true) => 0.0,
                    _ => weight * hashed(i, j, seed) + if i == j { 0.5 } else { 0.0 },
                }
            });
            let mut solver = analysed(BlockLu::new(), &pattern, Symmetric);
            // Blocks that are singular by chance are not for this solver.
            if solver.factorise(&values).is_ok() {
                let count = solver.negative_pivots(&values);
                assert_eq!(count, Some(negative(dense)), "size {size}, seed {seed}");
                counts.extend(count);
            }
        }
    }
    assert!(counts.len() > 40, "{}", counts.len());
}

#[test]
fn an_unsymmetric_matrix_has_no_count() {
    let pattern = BlockPattern::new(&[3; 4], chain(4));
    let (values, _) = matrix(&pattern, |i, j| if i == j { 2.0 } else { 0.1 });
    let mut general = analysed(BlockLu::new(), &pattern, General);
    general.factorise(&values).unwrap();
    assert_eq!(general.negative_pivots(&values), None);
    let mut interchanging = analysed(FaerLu::new(), &pattern, Symmetric);
    interchanging.factorise(&values).unwrap();
    assert_eq!(interchanging.negative_pivots(&values), None);
}

#[test]
fn saddle_points_that_need_interchanges_between_blocks_have_a_count() {
    // [K Gᵀ; G 0] with the multipliers in a block of their own, which has no diagonal at all; K is
    // positive definite in some directions and not in others.
    for seed in 0..20 {
        let pattern = BlockPattern::new(&[2, 6, 6, 6], [[0, 1], [0, 3], [1, 2], [2, 3]]);
        let (values, dense) = matrix(&pattern, |i, j| {
            let multiplier = |k: usize| k < 2;
            match (multiplier(i), multiplier(j)) {
                (true, true) => 0.0,
                (false, false) if i == j => [2.0, 2.0, -2.0][i % 3],
                (false, false) => 0.2 * hashed(i, j, seed),
                _ => hashed(i, j, seed),
            }
        });
        let mut solver = analysed(AutoSolver::new(), &pattern, Symmetric);
        solver.factorise(&values).unwrap();
        let count = solver.negative_pivots(&values);
        assert_eq!(count, Some(negative(dense)), "seed {seed}");
    }
}
