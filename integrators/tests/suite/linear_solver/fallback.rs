//! Regular matrices that blocks eliminated in their own order cannot solve: what the block solver says of
//! them, and that the general LU is asked instead.

#![allow(non_snake_case)]

use crate::support::linear_solver::*;
use pullback_integrators::linear_solver::{
    AutoSolver, BlockLu, LinearError, LinearSolver, SolverKind,
};
use pullback_manifold::sparse::BlockPattern;

/// A full matrix of scalar nodes, of which the last is eliminated first; a right-hand side of a known
/// solution; and beside them a node of six unknowns coupled to none of them, which makes it a matrix that
/// the block solver is chosen for.
struct Case {
    pattern: BlockPattern,
    values: Vec<f64>,
    x: Vec<f64>,
    b: Vec<f64>,
}

impl Case {
    fn new<const N: usize>(A: [[f64; N]; N], x: [f64; N]) -> Self {
        let sizes = [vec![1; N], vec![6]].concat();
        let pattern = BlockPattern::new(&sizes, [(0..N as u32).collect::<Vec<_>>()]);
        let mut values = vec![0.0; pattern.len()];
        write(&pattern, &mut values, |r, c| match r < N {
            true => A[r][c],
            false => f64::from(u8::from(r == c)),
        });
        let x = [&x[..], &[1.0; 6]].concat();
        let mut b = vec![0.0; N + 6];
        pattern.multiply_add(1.0, &values, &x, &mut b);
        Self {
            pattern,
            values,
            x,
            b,
        }
    }

    /// The block solver's error, of the same kind both ways and leaving b as it is.
    fn refusal(&self) -> LinearError {
        let solver = &mut BlockLu::new();
        let two_calls = solve(solver, &self.pattern, General, &self.values, &self.b).unwrap_err();
        let mut b = self.b.clone();
        let one_call = solver.factorise_and_solve(&self.values, &mut b);
        let kinds = [&one_call.unwrap_err(), &two_calls].map(std::mem::discriminant);
        assert_eq!(kinds[0], kinds[1]);
        assert_eq!(b, self.b);
        two_calls
    }

    /// Everybody's solver finds x, by the general LU, both ways and again.
    fn falls_back(&self) {
        let mut auto = analysed(AutoSolver::new(), &self.pattern, General);
        let mut harmless = self.values.clone();
        write(&self.pattern, &mut harmless, |r, c| {
            f64::from(u8::from(r == c))
        });
        auto.factorise(&harmless).unwrap();
        assert_eq!(auto.active(), Some(SolverKind::Block));
        let near = |found: &[f64]| {
            for (found, x) in found.iter().zip(&self.x) {
                assert!((found - x).abs() < 1e-9 * x.abs(), "{found} instead of {x}");
            }
        };
        for _ in 0..5 {
            let mut found = self.b.clone();
            auto.factorise(&self.values).unwrap();
            auto.solve(Some(&self.values), &mut found).unwrap();
            assert_eq!(auto.active(), Some(SolverKind::Lu));
            near(&found);
            let mut found = self.b.clone();
            auto.factorise_and_solve(&self.values, &mut found).unwrap();
            assert_eq!(auto.active(), Some(SolverKind::Lu));
            near(&found);
        }
    }
}

#[test]
fn elements_that_grow_are_noticed() {
    // The pivot 1e-13 is far above rounding, and leaves 1 − 1e13 for the other node.
    let case = Case::new([[1.0, 1.0], [1.0, 1e-13]], [1.0, 2.0]);
    let error = case.refusal();
    let LinearError::Growth { unknown: 0, growth } = error else {
        panic!("{error}");
    };
    // In a matrix with rows and columns of order one, s₁² 1e13 with s₁ s₂ about one.
    assert!(growth > 1e8, "{growth:e}");
    case.falls_back();
}

#[test]
fn residuals_that_refinement_does_not_mend_are_noticed() {
    // The pivot 3e-14 leaves 1/3e-14 in the places of 0.7 and 0.6, of which it takes all but two digits,
    // where it would have to cancel: with 1e-7 beside it no later pivot is as large. The matrix itself is
    // harmless: with its second row divided by 1e-7 its determinant is −0.1.
    let A = [[0.6, 0.7, -1.0], [0.0, 1e-12, 1e-7], [-1.0, -1.0, 3e-14]];
    let case = Case::new(A, [1.3, -0.7, 0.9]);
    let error = case.refusal();
    let LinearError::Residual { residual, limit } = error else {
        panic!("{error}");
    };
    assert!(limit == 1e-9 && residual > limit, "{error}");
    case.falls_back();
}
