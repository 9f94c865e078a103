//! Coordinates that a map may change for others.

use crate::support::dynamics::spring;
use crate::support::loops::Circle;
use crate::support::prelude::*;

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
