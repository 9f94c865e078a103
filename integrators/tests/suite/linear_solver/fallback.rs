//! Regular matrices that blocks eliminated in their own order cannot solve: what the block solver says of
//! them, and that the general LU is asked instead.

use crate::support::linear_solver::*;
use crate::support::*;

/// A matrix, a right-hand side and its solution.
struct Case {
    pattern: BlockPattern,
    symmetry: MatrixSymmetry,
    values: Vec<f64>,
    x: Vec<f64>,
    b: Vec<f64>,
}

impl Case {
    fn new(
        (pattern, values): (BlockPattern, Vec<f64>),
        symmetry: MatrixSymmetry,
        x: Vec<f64>,
    ) -> Self {
        let mut b = vec![0.0; x.len()];
        pattern.multiply_add(1.0, &values, &x, &mut b);
        Self {
            pattern,
            symmetry,
            values,
            x,
            b,
        }
    }

    fn of_scalars<const N: usize>(A: [[f64; N]; N], x: [f64; N]) -> Self {
        Self::new(scalars(A), General, [&x[..], &[1.0; 6]].concat())
    }

    /// The block solver's error, of the same kind both ways and leaving b as it is.
    fn refusal(&self) -> LinearError {
        let solver = &mut BlockLu::new(&self.pattern, self.symmetry).unwrap();
        let two_calls = solve(solver, &self.values, &self.b);
        let two_calls = two_calls.unwrap_err();
        let mut b = self.b.clone();
        let one_call = solver.factorise_and_solve(&self.values, &mut b);
        let kinds = [&one_call.unwrap_err(), &two_calls].map(std::mem::discriminant);
        assert_eq!(kinds[0], kinds[1]);
        assert_eq!(b, self.b);
        two_calls
    }

    /// Everybody's solver finds x, by the general LU, both ways and again.
    fn falls_back(&self) {
        let mut auto = AutoSolver::new(&self.pattern, self.symmetry).unwrap();
        let harmless = filled(&self.pattern, |r, c| f64::from(r == c));
        auto.factorise(&harmless).unwrap();
        assert_eq!(auto.active(), Some(SolverKind::Block));
        for _ in 0..5 {
            let mut found = self.b.clone();
            auto.factorise(&self.values).unwrap();
            auto.solve(Some(&self.values), &mut found).unwrap();
            assert_eq!(auto.active(), Some(SolverKind::Lu));
            self.near(&found);
            let mut found = self.b.clone();
            auto.factorise_and_solve(&self.values, &mut found).unwrap();
            assert_eq!(auto.active(), Some(SolverKind::Lu));
            self.near(&found);
        }
        // Signs need multipliers that are marked as such.
        assert_eq!(auto.negative_pivots(&self.values), None);
    }

    fn near(&self, found: &[f64]) {
        for (found, x) in found.iter().zip(&self.x) {
            let gap = (found - x).abs() / x.abs();
            assert!(gap < 1e-10, "{found} instead of {x}");
        }
    }
}

#[test]
fn elements_that_grow_are_noticed() {
    // The pivot 1e-13 is far above rounding, and leaves 1 − 1e13 for the other node.
    let case = Case::of_scalars([[1.0, 1.0], [1.0, 1e-13]], [1.0, 2.0]);
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
    let case = Case::of_scalars(A, [1.3, -0.7, 0.9]);
    let error = case.refusal();
    let LinearError::Residual { residual, limit } = error else {
        panic!("{error}");
    };
    assert!(limit == 1e-9 && residual > limit, "{error}");
    case.falls_back();
}

#[test]
fn a_saddle_point_needs_the_fallback_and_gets_it() {
    // Node 0 carries nothing but multipliers; it is eliminated first as a leaf of node 1.
    let pattern = BlockPattern::new(&[3, 2, 3], [[0, 1], [0, 2]]);
    let mut random = Random::new(5);
    let base = pattern.matrix(&random_values(&pattern, &mut random, true, true, 1.0));
    let multiplier = |i: usize| (3..5).contains(&i);
    let values = filled(&pattern, |r, c| match multiplier(r) && multiplier(c) {
        true => 0.0,
        false => base[(r, c)],
    });
    let x = random_numbers(8, &mut random);
    let case = Case::new((pattern, values), Symmetric, x);
    let error = case.refusal();
    let LinearError::VanishingPivot { unknown: 3, .. } = error else {
        panic!("{error}");
    };
    case.falls_back();
    let Case {
        pattern, values, ..
    } = &case;
    assert!(null_vector(pattern, values).is_none());

    // A constraint twice: the multipliers are not unique, and their difference is the null vector.
    let m = pattern.matrix(values);
    let same = |i: usize| if i == 4 { 3 } else { i };
    let doubled = filled(pattern, |r, c| m[(same(r), same(c))]);
    let mut auto = AutoSolver::new(pattern, Symmetric).unwrap();
    let error = auto.factorise(&doubled).unwrap_err();
    let (LinearError::VanishingPivot { unknown: 3 | 4, .. }
    | LinearError::Singular { unknown: 3 | 4, .. }) = error
    else {
        panic!("{error}");
    };
    let null = null_vector(pattern, &doubled).unwrap();
    assert!((null.vector[3] - 1.0).abs() < 1e-8 && (null.vector[4] + 1.0).abs() < 1e-8);
}

#[test]
fn matrices_that_fill_in_go_to_the_general_ldlt_and_from_there_to_the_lu() {
    for (saddle, kind) in [(false, SolverKind::Ldlt), (true, SolverKind::Lu)] {
        let pattern = BlockPattern::dense(500).with_coordinates(|i| CoordinateInfo {
            is_multiplier: saddle && i == 0,
            ..CoordinateInfo::default()
        });
        // Every third of the dominant diagonal entries is negative; at the saddle the first two entries are 0, and
        // eigenvalues ±1 take the place of −2 and 2.
        let values = filled(&pattern, |r, c| match r == c {
            true if saddle && r < 2 => 0.0,
            true if r % 3 == 0 => -2.0,
            true => 2.0,
            false if saddle && (r < 2 || c < 2) => f64::from(r + c == 1),
            false => 1e-3 * ((r + c) as f64).cos(),
        });
        let x = (1..=500).map(f64::from).collect();
        let case = Case::new((pattern.clone(), values), Symmetric, x);
        let mut auto = AutoSolver::new(&pattern, Symmetric).unwrap();
        for _ in 0..5 {
            auto.factorise(&case.values).unwrap();
            let mut found = case.b.clone();
            auto.solve(Some(&case.values), &mut found).unwrap();
            case.near(&found);
            assert_eq!(auto.active(), Some(kind));
            assert_eq!(auto.negative_pivots(&case.values), Some(167));
        }
    }
}
