//! What linear solvers say of matrices that are singular or not finite.

use crate::support::linear_solver::*;
use crate::support::*;
use nalgebra::DVector;

/// Scalar springs between neighbours, and to the ground at the nodes given.
fn springs(nodes: usize, grounded: &[usize], random: &mut Random) -> (BlockPattern, Vec<f64>) {
    let groups: Vec<[u32; 2]> = (1..nodes as u32).map(|i| [i - 1, i]).collect();
    let pattern = BlockPattern::new(&vec![1; nodes], &groups);
    let mut values = vec![0.0; pattern.len()];
    let mut add = |i: usize, j: usize, k: f64| values[pattern.find(i, j).unwrap()] += k;
    for [i, j] in groups.iter().map(|g| g.map(|i| i as usize)) {
        let k = 3.0 + random.range(-1.0, 1.0);
        for (a, b, k) in [(i, i, k), (j, j, k), (i, j, -k), (j, i, -k)] {
            add(a, b, k);
        }
    }
    for &i in grounded {
        add(i, i, 1.0);
    }
    (pattern, values)
}

fn is_singular(error: &LinearError) -> bool {
    matches!(
        error,
        LinearError::VanishingPivot { .. } | LinearError::Singular { .. }
    )
}

#[test]
fn an_unsupported_chain_is_singular_and_its_mechanism_is_a_translation() {
    let mut random = Random::new(2);
    for nodes in [2, 10, 1000, 10_000] {
        let (pattern, values) = springs(nodes, &[], &mut random);
        for symmetry in [General, Symmetric] {
            for (name, mut solver) in solvers(&pattern, symmetry) {
                let error = solver.factorise(&values).unwrap_err();
                assert!(is_singular(&error), "{name}: {error}");
                // Elimination runs from the tip to the base: there a support is missing.
                if name != "faer LU"
                    && let LinearError::VanishingPivot { unknown, .. } = error
                {
                    assert_eq!(unknown, 0, "{name}");
                }
            }
        }
        let null = null_vector(&pattern, &values).unwrap();
        let translates = null.vector.iter().all(|v| (v - 1.0).abs() < 1e-6);
        assert!(translates, "{nodes}: {null:?}");
        assert!(null.residual < 1e-13, "{nodes}: {:.1e}", null.residual);
        // Supported at either end it is regular, and has no null vector.
        for end in [0, nodes - 1] {
            let (pattern, values) = springs(nodes, &[end], &mut random);
            for (name, mut solver) in solvers(&pattern, General) {
                solver
                    .factorise(&values)
                    .unwrap_or_else(|e| panic!("{name}, {nodes}: {e}"));
            }
            assert!(null_vector(&pattern, &values).is_none());
        }
    }
}

#[test]
fn a_zero_row_is_named_by_everybody() {
    let mut random = Random::new(3);
    let pattern = BlockPattern::new(&[6, 6, 6], [[0, 1], [1, 2]]);
    let full = random_values(&pattern, &mut random, true, false, 1.0);
    let matrix = pattern.matrix(&full);
    let values = filled(&pattern, |r, c| match [r, c].contains(&9) {
        true => 0.0,
        false => matrix[(r, c)],
    });
    for (name, mut solver) in symmetric_solvers(&pattern) {
        let error = solver.factorise(&values).unwrap_err();
        assert_eq!(error, LinearError::ZeroRow { unknown: 9 }, "{name}");
        // And recovers.
        solver.factorise(&full).unwrap();
        solver.solve(Some(&full), &mut [1.0; 18]).unwrap();
    }
    let null = null_vector(&pattern, &values).unwrap();
    assert_eq!(null.vector.iter().position(|&v| v == 1.0), Some(9));
}

#[test]
fn exactly_singular_matrices_with_which_faer_reports_success_are_detected() {
    // Two equal rows within a block, and a structurally regular matrix of rank one.
    let pattern = BlockPattern::dense(2);
    for (name, mut solver) in symmetric_solvers(&pattern) {
        let error = solver.factorise(&[1.0, 1.0, 1.0, 1.0]).unwrap_err();
        assert!(is_singular(&error), "{name}: {error}");
    }
}

#[test]
fn null_vector_of_an_unsymmetric_matrix() {
    // A = B P with P annihilating `v`: rows of a regular B minus their product with v.
    let mut random = Random::new(4);
    let pattern = BlockPattern::new(&[3, 2, 4], [[0, 1], [1, 2], [0, 2]]);
    let n = pattern.dim();
    let regular = random_values(&pattern, &mut random, false, false, 1.0);
    let matrix = pattern.matrix(&regular);
    let v = DVector::from_fn(n, |i, _| {
        if i == 4 {
            1.0
        } else {
            0.8 * random.range(-1.0, 1.0)
        }
    });
    let projected = &matrix - (&matrix * &v) * v.transpose() / v.dot(&v);
    let values = filled(&pattern, |r, c| projected[(r, c)]);
    let null = null_vector(&pattern, &values).unwrap();
    for (a, b) in null.vector.iter().zip(v.iter()) {
        assert!((a - b).abs() < 1e-8, "{a} {b}");
    }
    assert!(null_vector(&pattern, &regular).is_none());
}

#[test]
fn values_that_are_not_finite_are_named() {
    let mut random = Random::new(6);
    let pattern = BlockPattern::new(&[6, 6], [[0, 1]]);
    let good = random_values(&pattern, &mut random, false, false, 1.0);
    let not_finite = |what, unknown| Err(LinearError::NonFinite { what, unknown });
    for bad in [f64::NAN, f64::INFINITY] {
        let mut values = good.clone();
        values[pattern.find(1, 0).unwrap() + 2] = bad;
        for (name, mut solver) in solvers(&pattern, General) {
            let expected = not_finite("matrix", 8);
            assert_eq!(solver.factorise(&values), expected, "{name}");
            let unready = solver.solve(Some(&values), &mut [0.0; 12]);
            assert!(matches!(unready, Err(LinearError::NotReady)));
            let at_once = solver.factorise_and_solve(&values, &mut [0.0; 12]);
            assert_eq!(at_once, expected, "{name}");
            solver.factorise(&good).unwrap();
            let mut b = [1.0; 12];
            b[5] = bad;
            let expected = not_finite("right-hand side", 5);
            assert_eq!(solver.solve(Some(&good), &mut b), expected, "{name}");
            let short = solver.solve(Some(&good), &mut [0.0; 11]);
            assert!(matches!(short, Err(LinearError::Length { .. })));
            let at_once = solver.factorise_and_solve(&good, &mut b);
            assert_eq!(at_once, expected, "{name}");
            assert!(b[0] == 1.0 && b[11] == 1.0, "{name} leaves b as it is");
            let short = solver.factorise_and_solve(&good, &mut [0.0; 11]);
            assert!(matches!(short, Err(LinearError::Length { .. })));
        }
    }
}
