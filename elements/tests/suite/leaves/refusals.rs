//! What no body and no spring can be, with the reason.

use crate::support::*;

#[test]
fn impossible_bodies_are_refused_with_their_reason() {
    let diagonal = |a: f64, b: f64, c: f64| Matrix3::from_diagonal(&Vector3::new(a, b, c));
    let body = |mass: f64, J: Matrix3<f64>, c: [f64; 3]| RigidBody::new(mass, J, c.into());
    let (J, zero) = (diagonal(2.0, 3.0, 4.0), [0.0; 3]);
    let mut skewed = J;
    skewed[(0, 2)] = 0.5;
    refused! {
        body(1.0, skewed, zero) =>
            "the inertia must be symmetric, but entries (1, 3) and (3, 1) are 0.5 and 0",
        body(f64::NAN, J, zero) => "the mass must be finite, got NaN",
        body(1.0, diagonal(1.0, f64::INFINITY, 1.0), zero) => "the inertia must be finite, got inf",
        body(1.0, J, [0.0, f64::NEG_INFINITY, 0.0]) => "the centre of mass must be finite, got -inf",
        body(-2.0, J, zero) => "the mass must be zero or positive, got -2",
        body(1.0, diagonal(-1.0, 3.0, 2.0), zero) =>
            "the inertia must be positive semidefinite, but its principal moments about the centre of \
             mass are [-1.0, 2.0, 3.0]",
        body(1.0, diagonal(5.0, 1.0, 3.0), zero) =>
            "no body has the principal moments of inertia [1.0, 3.0, 5.0] about its centre of mass: the \
             largest exceeds the sum of the others",
        body(0.0, Matrix3::zeros(), [1.0, 2.0, 3.0]) => "a body needs mass or inertia, both are zero",
        section().with_mass(-2.0, J) => "the mass must be zero or positive, got -2",
        section().with_mass(1.0, skewed) =>
            "the inertia must be symmetric, but entries (1, 3) and (3, 1) are 0.5 and 0",
        PointMass::new(0.0) => "the mass must be positive, got 0",
        PointMass::new(-1.0) => "the mass must be positive, got -1",
        PointMass::new(f64::NAN) => "the mass must be finite, got NaN",
    }
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
    // Of a section the rotary inertia of bending may be neglected.
    assert!(section().with_mass(1.0, diagonal(1.0, 0.0, 0.0)).is_ok());
}

#[test]
fn impossible_springs_are_refused_with_their_reason() {
    let ([a, b], zero) = (positions(), Vector3::zeros());
    let far = Vector3::new(0.0, f64::INFINITY, 0.0);
    let spring = AxialSpring::new;
    let none = CoordinateLaw::default();
    let law = CoordinateSpring::new;
    refused! {
        spring(&[a, b], -1.0, 0.0) => "the stiffness k must be zero or positive, got -1",
        spring(&[a, b], 1.0, f64::NAN) => "the damping c must be finite, got NaN",
        spring(&[a, b], 0.0, 0.0) => "a spring needs stiffness or damping, both are zero",
        spring(&[a, a], 1.0, 0.0) =>
            "the ends of a spring along a line must be apart, both are at [0.2, -0.3, 0.5]",
        spring(&[zero, zero], 1.0, 0.0) =>
            "the ends of a spring along a line must be apart, both are at [0.0, 0.0, 0.0]",
        spring(&[far, b], 1.0, 0.0) => "a position must be finite, got inf",
        spring(&[a, b], 1.0, 0.0).unwrap().with_rest_length(-0.1) =>
            "the rest length must be zero or positive, got -0.1",
        law(none) => "a spring needs stiffness or damping, both are zero",
        law(CoordinateLaw { c: -2.0, ..none }) => "the damping c must be zero or positive, got -2",
        law(CoordinateLaw { k: f64::NAN, ..none }) => "the stiffness k must be finite, got NaN",
        law(CoordinateLaw { k3: f64::INFINITY, ..none }) =>
            "the cubic stiffness k3 must be finite, got inf",
        law(CoordinateLaw { x0: f64::NAN, ..none }) => "the coordinate x0 must be finite, got NaN",
    }
}

#[test]
fn impossible_bushings_are_refused_with_their_reason() {
    let (none, one) = (Matrix6::zeros(), Matrix6::identity());
    let bushing = |axes: &Matrix3<f64>, K: &Matrix6<f64>, D: &Matrix6<f64>| {
        Bushing::new(&positions(), axes, K, D)
    };
    let I = Matrix3::identity();
    let pair = |upper: f64, lower: f64| {
        let mut K = one;
        (K[(1, 4)], K[(4, 1)]) = (upper, lower);
        K
    };
    let diagonal = |k: f64| {
        let mut K = one;
        K[(3, 3)] = k;
        K
    };
    let indefinite = "the damping D must be positive semidefinite; the diagonal is [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]";
    // A position that is nowhere.
    let nowhere = [Vector3::zeros(), Vector3::new(f64::NAN, 0.0, 0.0)];
    refused! {
        bushing(&I, &pair(0.5, 0.0), &none) =>
            "the stiffness K must be symmetric, but entries (2, 5) and (5, 2) are 0.5 and 0",
        bushing(&I, &one, &pair(1.5, 1.5)) => indefinite,
        bushing(&I, &one, &pair(-1.5, -1.5)) => indefinite,
        bushing(&I, &none, &none) => "a spring needs stiffness or damping, both are zero",
        bushing(&I, &diagonal(-1.0), &none) =>
            "the stiffness K must be positive semidefinite; the diagonal is [1.0, 1.0, 1.0, -1.0, 1.0, 1.0]",
        bushing(&I, &diagonal(f64::NAN), &none) => "the stiffness K must be finite, got NaN",
        Bushing::new(&nowhere, &I, &one, &none) => "a position must be finite, got NaN",
    }
    for axes in [I * 1.1, -I, I * f64::NAN] {
        let error = bushing(&axes, &one, &none).unwrap_err().to_string();
        assert!(error.contains("the columns of a rotation"), "{error}");
    }
    assert!(bushing(&I, &one, &pair(0.5, 0.5)).is_ok());
    // Zero rows are directions without stiffness, in any units.
    let K = Matrix6::from_diagonal(&Vector6::new(1e9, 0.0, 1e9, 1e-6, 0.0, 0.0));
    assert!(bushing(&axes(), &K, &none).is_ok());
}
