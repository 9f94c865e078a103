//! Negative pivots against the eigenvalues of a dense matrix (nalgebra): Sylvester's law.

use crate::support::linear_solver::*;
use crate::support::*;
use nalgebra::DMatrix;

fn chain(blocks: u32) -> Vec<[u32; 2]> {
    (1..blocks).map(|i| [i - 1, i]).collect()
}

#[test]
fn the_signs_of_pivots_are_those_of_eigenvalues() {
    let mut random = Random::new(7);
    for (shape, nodes, edges) in graphs().into_iter().filter(|graph| graph.1 <= 40) {
        for size in [1, 2, 3, 4, 6, 9] {
            let pattern = BlockPattern::new(&vec![size; nodes], &edges);
            for indefinite in [false, true] {
                // Dominant diagonals, of either sign: no solver needs to interchange rows.
                let values = random_values(&pattern, &mut random, true, indefinite, 1.0);
                let expected = negative(&pattern, &values);
                assert_eq!(expected > Some(0), indefinite);
                let all = symmetric_solvers(&pattern).into_iter();
                for (name, mut solver) in all.filter(|solver| solver.0 != "faer LU") {
                    assert_eq!(solver.negative_pivots(&values), None, "{name}: no factors");
                    solver.factorise(&values).unwrap();
                    let count = solver.negative_pivots(&values);
                    assert_eq!(count, expected, "{name}, {shape} of {size}");
                }
            }
        }
    }
}

#[test]
fn interchanges_inside_a_block_keep_the_count() {
    // Saddle points: half of the unknowns of each block have no diagonal, so that rows are
    // interchanged, and as many eigenvalues are negative as there are such unknowns.
    let (mut counts, mut random) = (Vec::new(), Random::new(8));
    for size in [2, 3, 4, 6, 8] {
        for seed in 0..20 {
            let pattern = BlockPattern::new(&[size; 12], chain(12));
            let n = pattern.dim();
            let mut base = DMatrix::from_fn(n, n, |_, _| random.range(-1.0, 1.0));
            base.fill_lower_triangle_with_upper_triangle();
            let values = filled(&pattern, |i, j| {
                let multiplier = |k: usize| k % size >= size / 2;
                let weight = if i / size == j / size { 1.0 } else { 0.02 };
                match (multiplier(i), multiplier(j)) {
                    (true, true) => 0.0,
                    _ => weight * base[(i, j)] + if i == j { 0.5 } else { 0.0 },
                }
            });
            let mut solver = BlockLu::new(&pattern, Symmetric).unwrap();
            // Blocks that are singular by chance are not for this solver.
            if solver.factorise(&values).is_ok() {
                let count = solver.negative_pivots(&values);
                assert_eq!(count, negative(&pattern, &values), "size {size}, {seed}");
                counts.extend(count);
            }
        }
    }
    assert!(counts.len() > 40, "{}", counts.len());
}

#[test]
fn an_unsymmetric_matrix_has_no_count() {
    let pattern = BlockPattern::new(&[3; 4], chain(4));
    let values = filled(&pattern, |i, j| if i == j { 2.0 } else { 0.1 });
    let mut general = BlockLu::new(&pattern, General).unwrap();
    general.factorise(&values).unwrap();
    assert_eq!(general.negative_pivots(&values), None);
    let mut interchanging = FaerLu::new(&pattern).unwrap();
    interchanging.factorise(&values).unwrap();
    assert_eq!(interchanging.negative_pivots(&values), None);
}
