//! Coordinates that a map may change for others.

use crate::support::dynamics::spring;
use crate::support::prelude::*;

/// Two coordinates on a circle: neither determines the other everywhere.
#[derive(Clone, Copy, Debug)]
struct Circle;

impl Implicit<2, 1> for Circle {
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, 2>) -> SVector<S, 1> {
        SVector::<S, 1>::new(x.dot(x) - 1.0)
    }
}

#[test]
fn coordinates_that_change_their_meaning_are_nobody_elses() {
    let build = |choice: Choice| {
        let map = ImplicitMap::of(Circle, 1, 0.0, [1.0, 0.0], choice).unwrap();
        let mut b = ModelBuilder::new();
        let q = b.coordinates("q", &[Quantity::Length]).unwrap();
        b.mapped_coordinates("x", &[Quantity::Length; 2], Box::new(map), &[q])
            .unwrap();
        spring(&mut b, 1.0, q);
        b.build().map(|_| ())
    };
    let error = build(Choice::Split).unwrap_err();
    assert!(
        matches!(error, ModelError::Reparametrized { .. }),
        "{error}"
    );
    assert!(error.to_string().contains("element spring"), "{error}");
    assert_eq!(build(Choice::Fixed), Ok(()));
}
