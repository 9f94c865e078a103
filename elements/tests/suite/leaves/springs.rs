//! Springs, dampers and bushings: laws and numbers.

use crate::support::*;

fn bushing() -> Bushing {
    Bushing::new(&positions(), &axes(), &full(0.3), &full(1.1)).unwrap()
}

fn axial() -> AxialSpring {
    AxialSpring::new(&positions(), 3.0, 0.7)
        .unwrap()
        .with_rest_length(0.9)
        .unwrap()
}

#[test]
fn springs_obey_the_laws_of_elements() {
    check::element(&axial()).assert();
    check::element(&AxialSpring::new(&positions(), 0.0, 1.3).unwrap()).assert();
    check::element(&bushing()).assert();
    let elastic = Bushing::new(&positions(), &axes(), &full(0.3), &Matrix6::zeros()).unwrap();
    check::element(&elastic).assert();
}

/// Forces on two nodes, that on the first one as given.
#[track_caller]
fn opposite(r: &DVector<f64>, first: [f64; 3]) {
    for k in 0..3 {
        assert!((r[k] - first[k]).abs() < 1e-14, "{r}");
        assert!((r[6 + k] + first[k]).abs() < 1e-14, "{r}");
    }
}

#[test]
fn a_spring_pulls_along_its_line() {
    // Nodes at 0 and (3, 4, 0) m, rest length 4 m, 10 N/m: 10 N along (0.6, 0.8, 0).
    let ends = [Vector3::zeros(), Vector3::new(3.0, 4.0, 0.0)];
    let spring = AxialSpring::new(&ends, 10.0, 2.0)
        .unwrap()
        .with_rest_length(4.0)
        .unwrap();
    let x = [0.0; 12];
    opposite(&residual(&spring, &x, &[]).unwrap(), [6.0, 8.0, 0.0]);
    assert_eq!(spring.energy(&moving(&x, &[], &[])), 5.0);
    assert_eq!(spring.tension(&moving(&x, &[], &[])), Ok(10.0));
    // The second node moves at 5 m/s along e2: l̇ = 4 m/s, 8 N more, 32 W.
    let mut v = [0.0; 12];
    v[7] = 5.0;
    opposite(&residual(&spring, &x, &v).unwrap(), [10.8, 14.4, 0.0]);
    assert!((spring.dissipation(&moving(&x, &v, &[])) - 32.0).abs() < 1e-13);
    // At the position of the first node there is no direction.
    let mut x = [0.0; 12];
    x[6..8].copy_from_slice(&[-3.0, -4.0]);
    refused! {
        residual(&spring, &x, &v) =>
            "its ends coincide (length 0.000e0): its force has no direction",
    }
    assert_eq!(spring.dissipation(&moving(&x, &v, &[])), 0.0);
}

/// Rounding errors of the ends are 1e-16 of their distance: at 1e-11 of it they leave a direction to
/// five digits, at 1e-13 hardly any, in metres as in millimetres.
#[test]
fn a_spring_has_a_direction_until_its_ends_nearly_coincide() {
    for unit in [1e-3, 1.0, 1e6] {
        let ends = [Vector3::zeros(), Vector3::new(3.0, 4.0, 0.0) * unit];
        let spring = AxialSpring::new(&ends, 10.0, 0.0).unwrap();
        let at = |part: f64| {
            let mut x = [0.0; 12];
            x[6..8].copy_from_slice(&[-3.0, -4.0].map(|x| x * unit * (1.0 - part)));
            residual(&spring, &x, &[])
        };
        // Pushed together by all of its length.
        let r = at(1e-11).unwrap() / (50.0 * unit);
        let off = (r[6] - 0.6).hypot(r[7] - 0.8);
        assert!(off < 1e-4, "{r}");
        let error = at(1e-13).unwrap_err().to_string();
        assert!(error.starts_with("its ends coincide"), "{error}");
    }
}

#[test]
fn a_bushing_answers_in_its_axes() {
    // Diagonal stiffness in axes turned by 90° about e3: E1 = e2, E2 = −e1, E3 = e3.
    let turned = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let K = Matrix6::from_diagonal(&Vector6::new(10.0, 20.0, 30.0, 1.0, 2.0, 3.0));
    let b = Bushing::new(&positions(), &turned, &K, &Matrix6::zeros()).unwrap();
    let mut x = [0.0; 12];
    x[6..9].copy_from_slice(&[0.1, 0.2, 0.3]);
    opposite(&residual(&b, &x, &[]).unwrap(), [2.0, 2.0, 9.0]);
    // Relative rotation about one principal axis is an angle: M = −3 · 2.5, beyond π −3 · 4.
    for angle in [2.5, 4.0] {
        let mut x = [0.0; 12];
        x[11] = angle;
        // The same with both nodes turned in common, about the same axis.
        for common in [0.0, 0.8] {
            let mut x = x;
            x[5] += common;
            x[11] += common;
            let c = so3::rotation(&Vector3::new(0.0, 0.0, common));
            let arm = positions()[1] - positions()[0];
            x[6..9].copy_from_slice((c * arm - arm).as_slice());
            let r = residual(&b, &x, &[]).unwrap();
            assert!((r[11] + 3.0 * angle).abs() < 1e-13, "{r}");
            assert!((r[5] - 3.0 * angle).abs() < 1e-13, "{r}");
            let energy = b.energy(&moving(&x, &[], &[]));
            assert!((energy - 1.5 * angle * angle).abs() < 1e-13);
        }
    }
    // Both rotation vectors of a node are one position only on their own sides of 2π.
    let mut x = [0.0; 12];
    x[5] = -PI;
    x[11] = PI - 1e-4;
    let error = residual(&b, &x, &[]).unwrap_err();
    let DomainError::Beyond { margin, .. } = error else {
        panic!("{error}");
    };
    assert!((margin + 9e-4).abs() < 1e-9, "{margin}");
}

#[test]
fn an_axial_spring_sees_no_rotations() {
    assert!(!axial().properties().sees_rotations);
    let (mut x, mut v) = ([0.1; 12], [0.3; 12]);
    (x[6], v[7]) = (0.4, -0.2);
    let still = residual(&axial(), &x, &v).unwrap();
    for k in [3, 4, 5, 9, 10, 11] {
        (x[k], v[k]) = (7.0 * k as f64, -3.0);
    }
    assert_eq!(residual(&axial(), &x, &v).unwrap(), still);
    assert!(bushing().properties().sees_rotations);
}
