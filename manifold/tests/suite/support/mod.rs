//! A constraint of one line, and the reference file.

pub mod double_double;

pub use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, SVector, Vector2, Vector3};
pub use pullback_conformance::{self as check, Layout, Mapped, Random, Report, TestState, motion};
pub use pullback_manifold::{chart::*, domain::*, implicit::*, jet::*, map::*, quotients::*};
pub use pullback_manifold::{scalar::*, sparse::BlockPattern, system::*};
use serde_json::Value;
pub use std::f64::consts::{PI, TAU};

/// A point on the unit circle.
#[derive(Clone, Copy, Debug)]
pub struct Circle;

impl Implicit<2, 1> for Circle {
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, 2>) -> SVector<S, 1> {
        SVector::<S, 1>::new(x[0] * x[0] + x[1] * x[1] - S::one())
    }
}

/// Unknowns x0, x1, ... that begin at these values or anywhere, and so many equations h0, h1, ... of them.
pub fn about(starts: &[Option<f64>], equations: usize) -> Description {
    let unknown = |(k, start): (usize, &Option<f64>)| Unknown {
        name: format!("x{k}"),
        size: 1.0,
        start: *start,
        preference: 0.0,
    };
    let equation = |i| Equation {
        name: format!("h{i}"),
        size: Some(1.0),
    };
    Description {
        unknowns: starts.iter().enumerate().map(unknown).collect(),
        equations: (0..equations).map(equation).collect(),
        good_condition: 10.0,
        ..Description::default()
    }
}

/// x and B.
pub fn tangent(map: &dyn Parametrization, t: f64, q: &[f64]) -> [Vec<f64>; 2] {
    let (d, n) = map.dims();
    let (mut x, mut B) = (vec![0.0; n], vec![0.0; n * d]);
    map.duplicate().tangent(t, q, &mut x, &mut B);
    [x, B]
}

/// The rows of a section of the reference tensors.
pub fn reference(section: &str) -> Vec<Value> {
    let text = include_str!("../../../../tests/reference/tensors.json");
    let data: Value = serde_json::from_str(text).expect("valid JSON");
    let rows = data[section].as_array().expect("rows").clone();
    assert_eq!(rows.len(), 4);
    rows
}

pub fn vector<const N: usize>(v: &Value) -> SVector<f64, N> {
    assert_eq!(v.as_array().map(Vec::len), Some(N));
    SVector::from_fn(|i, _| v[i].as_f64().expect("number"))
}

pub fn matrix<const R: usize, const C: usize>(v: &Value) -> SMatrix<f64, R, C> {
    assert_eq!(v.as_array().map(Vec::len), Some(R));
    SMatrix::from_fn(|i, j| v[i][j].as_f64().expect("number"))
}

/// Largest difference relative to the largest entry expected.
#[track_caller]
pub fn relative<const R: usize, const C: usize>(
    name: &str,
    found: &SMatrix<f64, R, C>,
    expected: &SMatrix<f64, R, C>,
    tolerance: f64,
) {
    let error = (found - expected).amax() / expected.amax().max(f64::MIN_POSITIVE);
    assert!(
        error <= tolerance,
        "{name}: {error:e}\n{found:e}{expected:e}"
    );
}
