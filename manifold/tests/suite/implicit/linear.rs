//! Linear equations, whose maps are known: dependent ones, and ones that need rows interchanged.

use crate::support::*;
use nalgebra::{Matrix2x3, Matrix3x4};

/// A x = 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Linear<const X: usize, const M: usize>(pub SMatrix<f64, M, X>);

impl<const X: usize, const M: usize> Implicit<X, M> for Linear<X, M> {
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, X>) -> SVector<S, M> {
        self.0.map(S::constant) * x
    }
}

fn map<const X: usize, const M: usize>(
    A: SMatrix<f64, M, X>,
    freedoms: usize,
    choice: Choice,
) -> ImplicitMap {
    ImplicitMap::of(Linear(A), freedoms, 0.0, [0.0; X], choice).unwrap()
}

/// Three vectors; the last is the sum of the others, and the longest.
const DEPENDENT: Matrix3x4<f64> = Matrix3x4::new(
    1.0, 2.0, 0.0, 1.0, //
    0.0, 1.0, 3.0, -1.0, //
    1.0, 3.0, 3.0, 0.0,
);

#[test]
fn dependent_gradients_leave_orthonormal_directions_across_them() {
    let map = map(DEPENDENT, 2, Choice::Tangent);
    assert_eq!((map.freedoms(), map.redundant().len()), (2, 1));
    let [_, B] = tangent(&map, 0.0, &[0.0; 2]);
    let B = SMatrix::<f64, 4, 2>::from_column_slice(&B);
    let defect = B.tr_mul(&B) - SMatrix::<f64, 2, 2>::identity();
    assert!(defect.amax() < 1e-15, "{defect}");
    let across = DEPENDENT * B;
    assert!(across.amax() < 4e-15, "{across}");
}

#[test]
fn the_coordinate_with_the_longest_column_is_dependent() {
    // Four equations for three coordinates, two of them independent.
    let map = map(DEPENDENT.transpose(), 1, Choice::Split);
    assert_eq!((map.freedoms(), map.redundant().len()), (1, 2));
    assert!(!map.independent().unwrap().contains(&2));
}

#[test]
fn equations_without_a_diagonal_are_inverted() {
    let A = Matrix3::new(
        0.0, 2.0, 1.0, //
        1.0, 0.0, 3.0, //
        2.0, 1.0, 0.0,
    );
    // A y = p: y = A⁻¹ p.
    let both = SMatrix::<f64, 3, 6>::from_fn(|i, j| match j {
        0..3 if i == j => -1.0,
        0..3 => 0.0,
        _ => A[(i, j - 3)],
    });
    let map = map(both, 3, Choice::Fixed)
        .with_independent(&[0, 1, 2])
        .unwrap();
    let [_, B] = tangent(&map, 0.0, &[0.0; 3]);
    let B = SMatrix::<f64, 6, 3>::from_column_slice(&B);
    assert_eq!(B.fixed_rows::<3>(0), Matrix3::identity());
    let one = A * B.fixed_rows::<3>(3);
    assert!((one - Matrix3::identity()).amax() < 1e-15, "{one}");
}

#[test]
fn coordinates_that_others_do_not_determine_are_refused() {
    // x = 0 and y + z = 0.
    let A = Matrix2x3::new(1.0, 0.0, 0.0, 0.0, 1.0, 1.0);
    for (independent, singular) in [(0, true), (1, false), (2, false)] {
        let map = map(A, 1, Choice::Fixed).with_independent(&[independent]);
        assert_eq!(map.is_none(), singular, "{independent}");
    }
}
