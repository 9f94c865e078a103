//! Springs, dampers and bushings: laws, equilibrium, moving observers, numbers.

#![allow(non_snake_case)]

use crate::support::{self, response};
use nalgebra::{DVector, Matrix3, Matrix6, SVector, Vector3, Vector6};
use pullback_conformance as check;
use pullback_conformance::Random;
use pullback_elements::element::{Abilities, Element, ElementEnergies, Motion, Response};
use pullback_elements::spring::{AxialSpring, Bushing, CoordinateLaw, CoordinateSpring};
use pullback_manifold::domain::DomainError;
use pullback_manifold::jet::Moving;
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3;
use std::f64::consts::PI;

type Vector12 = SVector<f64, 12>;

fn positions() -> [Vector3<f64>; 2] {
    [Vector3::new(0.2, -0.3, 0.5), Vector3::new(1.1, 0.4, -0.2)]
}

/// A symmetric positive definite 6×6 matrix in which everything couples.
fn full(shift: f64) -> Matrix6<f64> {
    let A = Matrix6::from_fn(|i, j| ((5 * i + 3 * j) as f64 + shift).sin());
    A * A.transpose() + Matrix6::identity() * 0.5
}

fn axes() -> Matrix3<f64> {
    so3::rotation(&Vector3::new(0.3, 0.8, -0.5))
}

fn bushing() -> Bushing {
    Bushing::new(&positions(), &axes(), &full(0.3), &full(1.1)).unwrap()
}

fn axial() -> AxialSpring {
    AxialSpring::new(&positions(), 3.0, 0.7)
        .unwrap()
        .with_rest_length(0.9)
        .unwrap()
}

fn residual(element: &dyn Element, x: &[f64], v: &[f64]) -> Result<DVector<f64>, DomainError> {
    let mut r = DVector::zeros(element.dim());
    let a = vec![0.0; v.len()];
    let mut out = response(r.as_mut_slice());
    let at = Motion {
        t: 0.37,
        ..support::moving(x, v, &a)
    };
    element.evaluate(&at, &mut out)?;
    Ok(r)
}

fn moving<'a>(x: &'a [f64], v: &'a [f64]) -> Motion<'a> {
    Motion {
        t: 0.37,
        ..support::moving(x, v, &[])
    }
}

#[test]
fn springs_obey_the_laws_of_elements() {
    check::element(&axial()).assert();
    check::element(&AxialSpring::new(&positions(), 0.0, 1.3).unwrap()).assert();
    check::element(&bushing()).assert();
    let elastic = Bushing::new(&positions(), &axes(), &full(0.3), &Matrix6::zeros()).unwrap();
    check::element(&elastic).assert();
    let law = CoordinateLaw {
        k: 2.0,
        k3: 0.7,
        c: 0.4,
        x0: 0.3,
    };
    check::element(&CoordinateSpring::new(law).unwrap()).assert();
}

/// Says that it dissipates what it does not.
struct Boastful(AxialSpring, f64);

impl Element for Boastful {
    fn dim(&self) -> usize {
        12
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        self.0.evaluate(at, out)
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities {
            combined: None,
            energies: Some(self),
            enforced: None,
            sections: None,
        }
    }
}

impl ElementEnergies for Boastful {
    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        self.1 * self.0.dissipation(at)
    }
}

#[test]
fn the_kit_finds_a_wrong_dissipation() {
    let failing = |factor: f64| {
        let report = check::element(&Boastful(axial(), factor));
        let mut laws: Vec<String> = report.failures().iter().map(|r| r.law.clone()).collect();
        laws.dedup();
        laws
    };
    assert!(failing(1.0).is_empty());
    assert!(failing(1.001).contains(&"power of damping = -dissipation".to_owned()));
    assert!(failing(-1.0).contains(&"dissipation >= 0".to_owned()));
}

/// Position, rotation and their rates of one node after the motion of space x → y(t) + Q(t) x, R → Q R,
/// Q(t) = R(turn + spin t), by jets at t = 0.
fn superpose(
    position: &Vector3<f64>,
    x: &[f64],
    v: &[f64],
    turn: &Vector3<f64>,
    spin: &Vector3<f64>,
) -> [[f64; 6]; 2] {
    let jet = |x: f64, rate: f64| Moving::<0>::given([x, rate, 0.0]);
    let turning = Vector3::from_fn(|i, _| jet(turn[i], spin[i]));
    let X = position.map(Moving::<0>::constant);
    let d = Vector3::from_fn(|i, _| jet(x[i], v[i]));
    let psi = Vector3::from_fn(|i, _| jet(x[3 + i], v[3 + i]));
    let shift = Vector3::new(jet(0.3, 0.9), jet(-0.7, 0.2), jet(0.5, -1.1));
    let d = so3::rotation(&turning) * (X + d) + shift - X;
    let product = so3::quaternion(&turning).product(&so3::quaternion(&psi));
    let psi = so3::log_quaternion(&product);
    let join = |of: fn(&Moving<0>) -> f64| {
        let mut out = [0.0; 6];
        for k in 0..3 {
            out[k] = of(&d[k]);
            out[3 + k] = of(&psi[k]);
        }
        out
    };
    [join(|x| x.x[0]), join(|x| x.x[1])]
}

/// Spatial force and moment of the covector of a node.
fn spatial(x: &[f64], r: &[f64]) -> [Vector3<f64>; 2] {
    let psi = Vector3::from_column_slice(&x[3..6]);
    let f = Vector3::from_column_slice(&r[3..6]);
    let moment = so3::rotation(&psi) * (so3::tangent_inverse(&psi).transpose() * f);
    [Vector3::from_column_slice(&r[..3]), moment]
}

#[test]
fn springs_turn_with_a_moving_observer() {
    // Also one that rotates and translates while he looks: damping is objective too.
    let (turn, spin) = (Vector3::new(0.9, -0.4, 1.2), Vector3::new(-0.8, 1.4, 0.3));
    let Q = so3::rotation(&turn);
    let mut random = Random::new(11);
    let elements: [Box<dyn Element>; 2] = [Box::new(axial()), Box::new(bushing())];
    for element in elements {
        let (x, v): (Vector12, Vector12) = (random.vector(), random.vector());
        let (x, v) = (x.as_slice(), v.as_slice());
        let (mut moved_x, mut moved_v) = ([0.0; 12], [0.0; 12]);
        for (i, position) in positions().iter().enumerate() {
            let node = 6 * i..6 * i + 6;
            let [p, w] = superpose(position, &x[node.clone()], &v[node.clone()], &turn, &spin);
            moved_x[node.clone()].copy_from_slice(&p);
            moved_v[node].copy_from_slice(&w);
        }
        let before = moving(x, v);
        let after = moving(&moved_x, &moved_v);
        let energy = element.abilities().energy(&before);
        assert!(energy > 0.0);
        assert!((element.abilities().energy(&after) - energy).abs() < 1e-13 * energy);
        let lost = element.abilities().dissipation(&before);
        assert!(lost > 0.0);
        assert!((element.abilities().dissipation(&after) - lost).abs() < 1e-12 * lost);
        let r = residual(&*element, x, v).unwrap();
        let found = residual(&*element, &moved_x, &moved_v).unwrap();
        for i in [0, 6] {
            let here = spatial(&x[i..], &r.as_slice()[i..]);
            let there = spatial(&moved_x[i..], &found.as_slice()[i..]);
            for (here, there) in here.iter().zip(there) {
                assert!((Q * here - there).norm() < 1e-12 * r.norm());
            }
        }
    }
}

#[test]
fn springs_are_in_equilibrium_with_themselves() {
    // Forces add up to zero, and so do their moments about the origin.
    let mut random = Random::new(12);
    let elements: [Box<dyn Element>; 2] = [Box::new(axial()), Box::new(bushing())];
    for element in elements {
        let (x, v): (Vector12, Vector12) = (random.vector(), random.vector());
        let r = residual(&*element, x.as_slice(), v.as_slice()).unwrap();
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for (i, position) in positions().iter().enumerate() {
            let [f, m] = spatial(&x.as_slice()[6 * i..], &r.as_slice()[6 * i..]);
            let at: Vector3<f64> = position + x.fixed_rows::<3>(6 * i);
            force += f;
            moment += m + at.cross(&f);
        }
        assert!(force.norm() < 1e-13 * r.norm());
        assert!(moment.norm() < 1e-13 * r.norm());
    }
}

#[test]
fn rigid_motions_of_all_nodes_strain_nothing() {
    let still = Vector3::zeros();
    let turn = Vector3::new(1.4, -2.0, 0.7);
    let mut x = [0.0; 12];
    for (i, position) in positions().iter().enumerate() {
        let [moved, _] = superpose(position, &[0.0; 6], &[0.0; 6], &turn, &still);
        x[6 * i..6 * i + 6].copy_from_slice(&moved);
    }
    let r = residual(&bushing(), &x, &[]).unwrap();
    assert!(r.amax() < 1e-14, "{r}");
    let relaxed = AxialSpring::new(&positions(), 3.0, 0.7).unwrap();
    let r = residual(&relaxed, &x, &[]).unwrap();
    assert!(r.amax() < 1e-14, "{r}");
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
    let near = |found: &DVector<f64>, expected: [f64; 3]| {
        for k in 0..3 {
            assert!((found[k] - expected[k]).abs() < 1e-14, "{found}");
            assert!((found[6 + k] + expected[k]).abs() < 1e-14, "{found}");
        }
    };
    near(&residual(&spring, &x, &[]).unwrap(), [6.0, 8.0, 0.0]);
    assert_eq!(spring.energy(&moving(&x, &[])), 5.0);
    assert_eq!(spring.tension(&moving(&x, &[])), Ok(10.0));
    // The second node moves at 5 m/s along e2: l̇ = 4 m/s, 8 N more, 32 W.
    let mut v = [0.0; 12];
    v[7] = 5.0;
    near(&residual(&spring, &x, &v).unwrap(), [10.8, 14.4, 0.0]);
    assert!((spring.dissipation(&moving(&x, &v)) - 32.0).abs() < 1e-13);
    // At the position of the first node there is no direction.
    let mut x = [0.0; 12];
    x[6..8].copy_from_slice(&[-3.0, -4.0]);
    let error = residual(&spring, &x, &v).unwrap_err();
    assert_eq!(
        error.to_string(),
        "its ends coincide (length 0.000e0): its force has no direction"
    );
    assert_eq!(spring.dissipation(&moving(&x, &v)), 0.0);
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
        assert!(
            (r[6] - 0.6).abs() < 1e-4 && (r[7] - 0.8).abs() < 1e-4,
            "{r}"
        );
        let error = at(1e-13).unwrap_err();
        assert!(
            error.to_string().starts_with("its ends coincide"),
            "{error}"
        );
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
    let r = residual(&b, &x, &[]).unwrap();
    for (k, expected) in [-2.0, -2.0, -9.0].into_iter().enumerate() {
        assert!((r[6 + k] - expected).abs() < 1e-14, "{r}");
        assert!((r[k] + expected).abs() < 1e-14, "{r}");
    }
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
            let energy = b.energy(&moving(&x, &[]));
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
    assert!((margin - 1e-4).abs() < 1e-9, "{margin}");
}

#[test]
fn a_bushing_without_rotation_is_an_axial_spring_of_any_direction() {
    // Isotropic, first node held: force −k (x₂ − X₂), the work of a linear spring of zero length.
    let mut K = Matrix6::zeros();
    for k in 0..3 {
        K[(k, k)] = 5.0;
    }
    let b = Bushing::new(&positions(), &Matrix3::identity(), &K, &Matrix6::zeros()).unwrap();
    let mut x = [0.0; 12];
    x[6..12].copy_from_slice(&[0.3, -0.8, 0.5, 0.9, 1.2, -0.4]);
    let r = residual(&b, &x, &[]).unwrap();
    for k in 0..3 {
        assert!((r[6 + k] + 5.0 * x[6 + k]).abs() < 1e-14);
        assert!(r[9 + k].abs() < 1e-14);
    }
}

#[test]
fn a_coordinate_spring_is_its_law() {
    let law = CoordinateLaw {
        k: 2.0,
        k3: 4.0,
        c: 0.5,
        x0: 1.0,
    };
    let spring = CoordinateSpring::new(law).unwrap();
    // −2·2 − 4·8 − 0.5·3 at x − x₀ = 2, ẋ = 3; energy ½·2·4 + ¼·4·16.
    assert_eq!(residual(&spring, &[3.0], &[3.0]).unwrap()[0], -37.5);
    assert_eq!(residual(&spring, &[3.0], &[]).unwrap()[0], -36.0);
    assert_eq!(spring.energy(&moving(&[3.0], &[])), 20.0);
    assert_eq!(spring.dissipation(&moving(&[3.0], &[3.0])), 4.5);
    assert_eq!(spring.dissipation(&moving(&[3.0], &[])), 0.0);
    // Two wells: softening first, hardening later.
    let law = CoordinateLaw {
        k: -1.0,
        k3: 1.0,
        ..CoordinateLaw::default()
    };
    let spring = CoordinateSpring::new(law).unwrap();
    assert_eq!(residual(&spring, &[1.0], &[]).unwrap()[0], 0.0);
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
