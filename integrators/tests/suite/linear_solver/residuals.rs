//! Residuals of solutions.

use crate::support::linear_solver::*;
use crate::support::*;

/// Largest relative residual of a solution that is returned.
const LIMIT: f64 = 1e-9;

/// Random values between −1 and 1 with a diagonal of `dominance`, so that all rows have one scale.
fn values(pattern: &BlockPattern, dominance: f64, random: &mut Random) -> Vec<f64> {
    let mut values = random_numbers(pattern.len(), random);
    for k in pattern.diagonal() {
        values[k] = dominance * values[k].signum();
    }
    values
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most, x| f64::max(most, x.abs()))
}

/// max|b − A x| / (‖A‖ max|x| + max|b|), ‖A‖ the largest block row's Frobenius norm.
fn relative(pattern: &BlockPattern, values: &[f64], x: &[f64], b: &[f64]) -> f64 {
    let mut r = b.to_vec();
    pattern.multiply_add(-1.0, values, x, &mut r);
    let mut squares = vec![0.0; pattern.blocks()];
    for j in 0..pattern.blocks() {
        for (i, range) in pattern.column(j) {
            squares[i] += values[range].iter().map(|a| a * a).sum::<f64>();
        }
    }
    largest(&r) / (largest(&squares).sqrt() * largest(x) + largest(b))
}

#[test]
fn residuals_of_solutions_are_small() {
    let chain = BlockPattern::new(&[6; 40], (0..39).map(|i| vec![i, i + 1]));
    let sizes: Vec<usize> = (0..40).map(|i| [6, 3, 1, 2, 5][i % 5]).collect();
    let web = (0..60).map(|i| vec![i % 40, (i * 7 + 3) % 40]);
    let web = BlockPattern::new(&sizes, web.filter(|e| e[0] != e[1]));
    let mut random = Random::new(1);
    let mut solved = 0;
    for pattern in [&chain, &web] {
        let unknown = vec![f64::NAN; pattern.len()];
        for dominance in [0.01, 0.1, 0.5, 2.0, 20.0] {
            for _ in 0..20 {
                let values = values(pattern, dominance, &mut random);
                let b = random_numbers(pattern.dim(), &mut random);
                let mut solver = BlockLu::new(pattern, General).unwrap();
                if solver.factorise(&values).is_err() {
                    continue;
                }
                let mut x = b.clone();
                assert!(solver.solve(Some(&unknown), &mut x).is_err());
                assert_eq!(x, b, "it is untouched");
                if solver.solve(Some(&values), &mut x).is_ok() {
                    solved += 1;
                    let residual = relative(pattern, &values, &x, &b);
                    assert!(residual <= LIMIT, "{residual:e} at {dominance}");
                }
            }
        }
    }
    assert!(solved > 40, "{solved}");
}
