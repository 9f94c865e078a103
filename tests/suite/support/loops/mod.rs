//! Shared by the tests of closed loops.

pub mod four_bar;
pub mod linkage;

use crate::support::prelude::*;

pub const G: f64 = 9.81;

/// Weight along −e2 of whatever can be weighed.
pub const DOWN: [f64; 3] = [0.0, -G, 0.0];

pub fn gap(found: &[f64], exact: &[f64]) -> f64 {
    assert_eq!(found.len(), exact.len());
    let gaps = found.iter().zip(exact).map(|(a, b)| (a - b).abs());
    gaps.fold(0.0, f64::max)
}

/// The derivative by θ of a quantity with two derivatives.
pub fn slope(x: Moving<0>) -> Moving<0> {
    Moving::given([x.x[1], x.x[2], 0.0])
}

/// Accelerations of one coordinate: M θ̈ + ½ M′ θ̇² + V′ = 0.
pub fn one_freedom(M: Moving<0>, V: Moving<0>, rate: f64) -> f64 {
    -(0.5 * M.x[1] * rate * rate + V.x[1]) / M.x[0]
}

/// Two coordinates on a circle: neither determines the other everywhere.
#[derive(Clone, Copy, Debug)]
pub struct Circle;

impl Implicit<2, 1> for Circle {
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, 2>) -> SVector<S, 1> {
        SVector::<S, 1>::new(x.dot(x) - 1.0)
    }
}
