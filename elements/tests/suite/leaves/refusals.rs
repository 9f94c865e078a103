//! What no body and no spring can be, with the reason.

#![allow(non_snake_case)]

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use pullback_elements::Asymmetry;
use pullback_elements::body::{PointMass, RigidBody};
use pullback_elements::inertia::InertiaError;
use pullback_elements::spring::{
    AxialSpring, Bushing, CoordinateLaw, CoordinateSpring, SpringError,
};
use pullback_manifold::so3;

fn positions() -> [Vector3<f64>; 2] {
    [Vector3::new(0.2, -0.3, 0.5), Vector3::new(1.1, 0.4, -0.2)]
}

fn axes() -> Matrix3<f64> {
    so3::rotation(&Vector3::new(0.3, 0.8, -0.5))
}

#[test]
fn impossible_bodies_are_refused_with_their_reason() {
    let diagonal = |a: f64, b: f64, c: f64| Matrix3::from_diagonal(&Vector3::new(a, b, c));
    let message = |mass: f64, J: Matrix3<f64>, c: [f64; 3]| {
        RigidBody::new(mass, J, c.into()).unwrap_err().to_string()
    };
    let J = diagonal(2.0, 3.0, 4.0);
    let zero = [0.0; 3];
    assert_eq!(
        message(f64::NAN, J, zero),
        "the mass must be finite, got NaN"
    );
    assert_eq!(
        message(1.0, diagonal(1.0, f64::INFINITY, 1.0), zero),
        "the inertia must be finite, got inf"
    );
    assert_eq!(
        message(1.0, J, [0.0, f64::NEG_INFINITY, 0.0]),
        "the centre of mass must be finite, got -inf"
    );
    assert_eq!(
        message(-2.0, J, zero),
        "the mass must be zero or positive, got -2"
    );
    assert_eq!(
        message(1.0, diagonal(-1.0, 3.0, 2.0), zero),
        "the inertia must be positive semidefinite, but its principal moments about the centre of mass are [-1.0, 2.0, 3.0]"
    );
    assert_eq!(
        message(1.0, diagonal(5.0, 1.0, 3.0), zero),
        "no body has the principal moments of inertia [1.0, 3.0, 5.0] about its centre of mass: the \
         largest exceeds the sum of the others"
    );
    assert_eq!(
        message(0.0, Matrix3::zeros(), [1.0, 2.0, 3.0]),
        "a body needs mass or inertia, both are zero"
    );
    let mut skewed = J;
    skewed[(0, 2)] = 0.5;
    assert_eq!(
        RigidBody::new(1.0, skewed, Vector3::zeros()).unwrap_err(),
        InertiaError::NotSymmetric(Asymmetry {
            row: 1,
            column: 3,
            upper: 0.5,
            lower: 0.0
        })
    );
    // Rods, plates and points are bodies, also with the round-off of a rotation or of a table.
    let R = so3::rotation(&Vector3::new(0.4, -0.7, 1.1));
    for J in [
        diagonal(0.0, 1.0, 1.0),
        diagonal(1.0, 2.0, 3.0),
        diagonal(0.333333, 0.333333, 0.666667),
        Matrix3::zeros(),
    ] {
        let J = R * J * R.transpose();
        assert!(RigidBody::new(1.0, J, Vector3::zeros()).is_ok(), "{J}");
    }
    for mass in [0.0, -1.0] {
        assert_eq!(
            PointMass::new(mass).unwrap_err().to_string(),
            format!("the mass must be positive, got {mass}")
        );
    }
    assert!(PointMass::new(f64::NAN).is_err());
}

#[test]
fn impossible_springs_are_refused_with_their_reason() {
    let message = |r: Result<AxialSpring, SpringError>| r.unwrap_err().to_string();
    let ends = positions();
    assert_eq!(
        message(AxialSpring::new(&ends, -1.0, 0.0)),
        "the stiffness k must be zero or positive, got -1"
    );
    assert_eq!(
        message(AxialSpring::new(&ends, 1.0, f64::NAN)),
        "the damping c must be finite, got NaN"
    );
    assert_eq!(
        message(AxialSpring::new(&ends, 0.0, 0.0)),
        "a spring needs stiffness or damping, both are zero"
    );
    assert_eq!(
        message(AxialSpring::new(&[ends[0]; 2], 1.0, 0.0)),
        "the ends of a spring along a line must be apart, both are at [0.2, -0.3, 0.5]"
    );
    assert_eq!(
        message(AxialSpring::new(&[Vector3::zeros(); 2], 1.0, 0.0)),
        "the ends of a spring along a line must be apart, both are at [0.0, 0.0, 0.0]"
    );
    assert_eq!(
        message(AxialSpring::new(
            &[Vector3::new(0.0, f64::INFINITY, 0.0), ends[1]],
            1.0,
            0.0
        )),
        "a position must be finite, got inf"
    );
    assert_eq!(
        message(
            AxialSpring::new(&ends, 1.0, 0.0)
                .unwrap()
                .with_rest_length(-0.1)
        ),
        "the rest length must be zero or positive, got -0.1"
    );
    let coordinate = |law| CoordinateSpring::new(law).unwrap_err().to_string();
    let zero = CoordinateLaw::default();
    assert_eq!(
        coordinate(zero),
        "a spring needs stiffness or damping, both are zero"
    );
    for (law, expected) in [
        (
            CoordinateLaw { c: -2.0, ..zero },
            "the damping c must be zero or positive, got -2",
        ),
        (
            CoordinateLaw {
                k: f64::NAN,
                ..zero
            },
            "the stiffness k must be finite, got NaN",
        ),
        (
            CoordinateLaw {
                k3: f64::INFINITY,
                ..zero
            },
            "the cubic stiffness k3 must be finite, got inf",
        ),
        (
            CoordinateLaw {
                x0: f64::NAN,
                ..zero
            },
            "the coordinate x0 must be finite, got NaN",
        ),
    ] {
        assert_eq!(coordinate(law), expected);
    }
}

#[test]
fn impossible_bushings_are_refused_with_their_reason() {
    let (none, one) = (Matrix6::zeros(), Matrix6::identity());
    let refused = |axes: &Matrix3<f64>, K: &Matrix6<f64>, D: &Matrix6<f64>| {
        Bushing::new(&positions(), axes, K, D).unwrap_err()
    };
    let I = Matrix3::identity();
    assert_eq!(refused(&I, &none, &none), SpringError::Nothing);
    let mut skewed = one;
    skewed[(1, 4)] = 0.5;
    let error = refused(&I, &skewed, &none);
    assert_eq!(
        error.to_string(),
        "the stiffness K must be symmetric, but entries (2, 5) and (5, 2) are 0.5 and 0"
    );
    skewed[(4, 1)] = 0.5;
    assert!(Bushing::new(&positions(), &I, &one, &skewed).is_ok());
    for c in [1.5, -1.5] {
        skewed[(1, 4)] = c;
        skewed[(4, 1)] = c;
        assert_eq!(
            refused(&I, &one, &skewed).to_string(),
            "the damping D must be positive semidefinite; the diagonal is \
             [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]"
        );
    }
    let mut negative = one;
    negative[(3, 3)] = -1.0;
    assert!(matches!(
        refused(&I, &negative, &none),
        SpringError::NotPositiveSemidefinite { .. }
    ));
    negative[(3, 3)] = f64::NAN;
    assert!(matches!(
        refused(&I, &negative, &none),
        SpringError::NotFinite { .. }
    ));
    for axes in [I * 1.1, -I, I * f64::NAN] {
        let error = refused(&axes, &one, &none);
        assert!(matches!(error, SpringError::Axes { .. }), "{error}");
        assert!(
            error
                .to_string()
                .contains("must be the columns of a rotation")
        );
    }
    // A position at infinity.
    let far = [Vector3::zeros(), Vector3::new(f64::NAN, 0.0, 0.0)];
    assert_eq!(
        Bushing::new(&far, &I, &one, &none).unwrap_err().to_string(),
        "a position must be finite, got NaN"
    );
    // Zero rows are directions without stiffness, in any units.
    let K = Matrix6::from_diagonal(&Vector6::new(1e9, 0.0, 1e9, 1e-6, 0.0, 0.0));
    assert!(Bushing::new(&positions(), &axes(), &K, &none).is_ok());
}
