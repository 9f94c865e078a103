//! Bodies: their laws, the reference, an energy differentiated, Euler's equations.

#![allow(non_snake_case)]

use crate::support::{in_charts, matrix, numbers, reference, vector};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, SVector, Vector3, Vector6};
use pullback_conformance as check;
use pullback_conformance::Random;
use pullback_elements::body::{PointMass, RigidBody};
use pullback_elements::element::{Element, ElementEnergies, Motion, Response};
use pullback_elements::inertia::Inertia;
use pullback_manifold::domain::{CHART_EDGE, DomainError};
use pullback_manifold::jet::{Grad, Moving};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3;

/// A symmetric inertia with principal moments 2.5, 3, 4 and axes that are not the global ones.
fn inertia() -> Matrix3<f64> {
    let R = so3::rotation(&Vector3::new(0.4, -0.7, 1.1));
    R * Matrix3::from_diagonal(&Vector3::new(2.5, 3.0, 4.0)) * R.transpose()
}

const CENTER: [f64; 3] = [0.3, -0.5, 0.8];

/// A body whose node is not its centre of mass.
fn eccentric() -> RigidBody {
    RigidBody::new(1.7, inertia(), CENTER.into()).unwrap()
}

fn centred() -> RigidBody {
    RigidBody::new(1.7, inertia(), Vector3::zeros()).unwrap()
}

/// Residual, K, C and M at (x, v, a).
type All = (DVector<f64>, DMatrix<f64>, DMatrix<f64>, DMatrix<f64>);

fn all(element: &dyn Element, x: &[f64], v: &[f64], a: &[f64]) -> Result<All, DomainError> {
    let n = element.dim();
    let zeros = || DMatrix::zeros(n, n);
    let (mut r, mut K, mut C, mut M) = (DVector::zeros(n), zeros(), zeros(), zeros());
    let mut out = Response {
        r: r.as_mut_slice(),
        K: Some(K.as_mut_slice()),
        C: Some(C.as_mut_slice()),
        M: Some(M.as_mut_slice()),
        r_t: None,
    };
    let at = Motion {
        t: 0.0,
        inputs: &[],
        x,
        v,
        a,
        previous: None,
    };
    in_charts(element, &at, &mut out)?;
    Ok((r, K, C, M))
}

/// Kinetic energy of a body in charts.
fn kinetic(body: &RigidBody, at: &Motion<'_>) -> f64 {
    let energy = check::InCharts(body).abilities().kinetic_energy(at);
    energy.expect("of its own")
}

#[test]
fn bodies_obey_the_laws_of_elements() {
    check::element(&eccentric()).assert();
    check::element(&centred()).assert();
    check::element(&PointMass::new(2.5).unwrap()).assert();
    let wheel = RigidBody::new(0.0, inertia(), CENTER.into()).unwrap();
    check::element(&wheel).assert();
}

#[test]
fn the_rigid_body_is_that_of_the_reference() {
    let rows = reference("rigid_body");
    assert!(!rows.is_empty());
    for row in &rows {
        let J = numbers(&row["J"]);
        let J = Matrix3::from_diagonal(&Vector3::from_vec(J));
        let body = RigidBody::new(3.0, J, Vector3::zeros()).unwrap();
        let extend = |key: &str| {
            let mut all = vec![0.7, -0.2, 0.4];
            all.extend(numbers(&row[key]));
            all
        };
        let (x, v, a) = (extend("psi"), extend("psi_dot"), extend("psi_ddot"));
        let (r, K, C, M) = all(&body, &x, &v, &a).unwrap();
        let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-11);
        let f = vector(&row["f_acc"]);
        for k in 0..3 {
            close(-r[k], 3.0 * a[k]);
            close(-r[3 + k], f[k]);
        }
        for (found, key) in [(&M, "M"), (&C, "C_gyro"), (&K, "K_cent")] {
            let expected = matrix(&row[key]);
            for i in 0..3 {
                for j in 0..3 {
                    close(found[(3 + i, 3 + j)], expected[(i, j)]);
                }
            }
        }
        let at = Motion {
            t: 0.0,
            inputs: &[],
            x: &x,
            v: &v,
            a: &a,
            previous: None,
        };
        let translation = 1.5 * v[..3].iter().map(|v| v * v).sum::<f64>();
        let energy = row["kinetic_energy"].as_f64().expect("number");
        close(kinetic(&body, &at), energy + translation);
    }
}

/// Kinetic energy of the eccentric body as that of its centre of mass, x_c = x + R c, and about it.
fn kinetic_energy<S: Scalar>(z: &SVector<S, 12>) -> S {
    let triple = |i: usize| Vector3::new(z[i], z[i + 1], z[i + 2]);
    let (psi, x_dot, psi_dot) = (triple(3), triple(6), triple(9));
    let c = Vector3::from(CENTER).map(S::constant);
    let Omega = so3::tangent(&psi) * psi_dot;
    let v = x_dot + so3::rotation(&psi) * Omega.cross(&c);
    let L = inertia().map(S::constant) * Omega;
    (v.dot(&v) * 1.7 + Omega.dot(&L)) * 0.5
}

/// f_acc = d/dt ∂T/∂q̇ − ∂T/∂q with derivatives of [`kinetic_energy`] alone.
fn lagrange<S: Scalar>(q: &Vector6<S>, v: &Vector6<S>, a: &Vector6<S>) -> Vector6<S> {
    let z = SVector::<Grad<Grad<S, 12>, 12>, 12>::from_fn(|i, _| {
        let value = if i < 6 { q[i] } else { v[i - 6] };
        Grad::variable(Grad::variable(value, i), i)
    });
    let T = kinetic_energy(&z);
    Vector6::from_fn(|i, _| {
        let mut f = -T.g[i].v;
        for j in 0..6 {
            f += T.g[6 + i].g[j] * v[j] + T.g[6 + i].g[6 + j] * a[j];
        }
        f
    })
}

#[test]
fn forces_and_tangents_are_derivatives_of_the_kinetic_energy() {
    let mut random = Random::default();
    let body = eccentric();
    for scale in [0.0, 1e-8, 0.5, 1.5, 3.2] {
        let mut q: Vector6<f64> = random.vector();
        random.direction(scale, &mut q.as_mut_slice()[3..]);
        let (v, a): (Vector6<f64>, Vector6<f64>) = (random.vector(), random.vector());
        let (r, K, C, M) = all(&body, q.as_slice(), v.as_slice(), a.as_slice()).unwrap();
        let f = lagrange(&q, &v, &a);
        for i in 0..6 {
            assert!((r[i] + f[i]).abs() < 1e-12, "{scale}: {r} for {f}");
        }
        // One coordinate, velocity or acceleration at a time.
        type One = Grad<f64, 1>;
        let plain = |x: &Vector6<f64>| x.map(One::constant);
        let varied = |x: &Vector6<f64>, j: usize| {
            let mut x = plain(x);
            x[j] = One::variable(x[j].v, 0);
            x
        };
        for j in 0..6 {
            let columns = [
                (lagrange(&varied(&q, j), &plain(&v), &plain(&a)), &K),
                (lagrange(&plain(&q), &varied(&v, j), &plain(&a)), &C),
                (lagrange(&plain(&q), &plain(&v), &varied(&a, j)), &M),
            ];
            for (k, (column, found)) in columns.iter().enumerate() {
                for i in 0..6 {
                    let error = (found[(i, j)] - column[i].g[0]).abs();
                    assert!(error < 1e-11, "{scale}, {k}, ({i}, {j}): {error:e}");
                }
            }
        }
    }
}

/// Material angular velocity and acceleration of Ψ(t) from R(Ψ(t)) alone: Ω~ = RᵀṘ.
fn turning(q: &Vector6<f64>, v: &Vector6<f64>, a: &Vector6<f64>) -> [Vector3<f64>; 2] {
    let psi = Vector3::from_fn(|i, _| Moving::<0>::given([q[3 + i], v[3 + i], a[3 + i]]));
    let R = so3::rotation(&psi);
    let [R, R_dot, R_ddot] = [0, 1, 2].map(|k| R.map(|r| r.x[k]));
    // RᵀR̈ = Ω̇~ + Ω~Ω~, of which the square is symmetric.
    [
        so3::axial(&R.tr_mul(&R_dot)),
        so3::axial(&R.tr_mul(&R_ddot)),
    ]
}

#[test]
fn a_free_body_obeys_eulers_equations() {
    let mut random = Random::new(3);
    for body in [centred(), eccentric()] {
        let c = body.inertia().S / body.inertia().mass;
        for _ in 0..5 {
            let (q, v): (Vector6<f64>, Vector6<f64>) = (random.vector(), random.vector());
            // r(q, v, a) = −f(q, v) − M a = 0.
            let (r, _, _, M) = all(&body, q.as_slice(), v.as_slice(), &[0.0; 6]).unwrap();
            let a = M.lu().solve(&r).unwrap();
            let a = Vector6::from_column_slice(a.as_slice());
            let [Omega, A] = turning(&q, &v, &a);
            // About the centre of mass, J_c Ω̇ = −Ω × J_c Ω, and the centre of mass is not
            // accelerated: linear momentum and spatial angular momentum are constant.
            let J = inertia();
            assert!((J * A + Omega.cross(&(J * Omega))).norm() < 1e-12);
            let R = so3::rotation(&Vector3::new(q[3], q[4], q[5]));
            let acceleration =
                a.fixed_rows::<3>(0) + R * (A.cross(&c) + Omega.cross(&Omega.cross(&c)));
            assert!(acceleration.norm() < 1e-12, "{acceleration}");
        }
    }
}

#[test]
fn kinetic_energy_is_half_the_mass_form_and_its_rate_the_power() {
    let mut random = Random::new(4);
    let body = eccentric();
    let (q, v, a): (Vector6<f64>, Vector6<f64>, Vector6<f64>) =
        (random.vector(), random.vector(), random.vector());
    let (r, _, _, M) = all(&body, q.as_slice(), v.as_slice(), a.as_slice()).unwrap();
    let energy = |q: &Vector6<f64>, v: &Vector6<f64>| {
        let at = Motion {
            t: 0.0,
            inputs: &[],
            x: q.as_slice(),
            v: v.as_slice(),
            a: &[0.0; 6],
            previous: None,
        };
        kinetic(&body, &at)
    };
    let M = Matrix6::from_column_slice(M.as_slice());
    let T = energy(&q, &v);
    assert!((T - 0.5 * v.dot(&(M * v))).abs() < 1e-14);
    // dT/dt = f_acc·q̇, exactly, along q + q̇τ, q̇ + q̈τ.
    let z = SVector::<Grad<f64, 1>, 12>::from_fn(|i, _| Grad {
        v: if i < 6 { q[i] } else { v[i - 6] },
        g: [if i < 6 { v[i] } else { a[i - 6] }],
    });
    let along = kinetic_energy(&z);
    assert!((along.v - T).abs() < 1e-14);
    let power: f64 = r.iter().zip(v.iter()).map(|(r, v)| -r * v).sum();
    assert!((along.g[0] - power).abs() < 1e-13);
    // In statics there is neither.
    let at = Motion {
        t: 0.0,
        inputs: &[],
        x: q.as_slice(),
        v: &[],
        a: &[],
        previous: None,
    };
    assert_eq!(kinetic(&body, &at), 0.0);
    assert_eq!(PointMass::new(2.0).unwrap().kinetic_energy(&at), Some(0.0));
    let at = Motion {
        v: v.as_slice(),
        ..at
    };
    let mass = PointMass::new(2.0).unwrap();
    assert_eq!(
        mass.kinetic_energy(&at),
        Some(v.fixed_rows::<3>(0).norm_squared())
    );
}

#[test]
fn inertia_turns_with_the_observer() {
    // A body and its motion turned as a whole by Q: the same energy, the force turned.
    let mut random = Random::new(5);
    let Q = so3::rotation(&Vector3::new(-0.8, 0.3, 1.9));
    let turned = RigidBody::new(
        1.7,
        Q * inertia() * Q.transpose(),
        Q * Vector3::from(CENTER),
    )
    .unwrap();
    let (q, v, a): (Vector6<f64>, Vector6<f64>, Vector6<f64>) =
        (random.vector(), random.vector(), random.vector());
    let turn = |x: &Vector6<f64>| {
        let (d, psi) = (Q * x.fixed_rows::<3>(0), Q * x.fixed_rows::<3>(3));
        Vector6::new(d.x, d.y, d.z, psi.x, psi.y, psi.z)
    };
    let (r, ..) = all(&eccentric(), q.as_slice(), v.as_slice(), a.as_slice()).unwrap();
    let (q, v, a) = (turn(&q), turn(&v), turn(&a));
    let (found, ..) = all(&turned, q.as_slice(), v.as_slice(), a.as_slice()).unwrap();
    let expected = turn(&Vector6::from_column_slice(r.as_slice()));
    for i in 0..6 {
        assert!((found[i] - expected[i]).abs() < 1e-13);
    }
}

#[test]
fn a_superposed_rotation_of_space_changes_no_force_but_turns_it() {
    // x → Q x, R → Q R with Q fixed: spatial force and moment are turned by Q.
    let q = Vector6::new(0.2, -0.4, 0.3, 0.5, 0.7, -0.2);
    let v = Vector6::new(1.0, 0.3, -0.6, 0.4, -0.9, 1.1);
    let a = Vector6::new(-0.3, 0.8, 0.5, 1.2, 0.1, -0.7);
    let turn = Vector3::new(0.3, -0.2, 0.6);
    let Q = so3::rotation(&turn);
    let psi = Vector3::from_fn(|i, _| Moving::<0>::given([q[3 + i], v[3 + i], a[3 + i]]));
    let product = so3::quaternion(&turn.map(Moving::<0>::constant)).product(&so3::quaternion(&psi));
    let after = so3::log_quaternion(&product);
    let join =
        |d: Vector3<f64>, psi: Vector3<f64>| Vector6::new(d.x, d.y, d.z, psi.x, psi.y, psi.z);
    let d = |x: &Vector6<f64>| Q * x.fixed_rows::<3>(0);
    let moved = [
        join(d(&q), after.map(|x| x.x[0])),
        join(d(&v), after.map(|x| x.x[1])),
        join(d(&a), after.map(|x| x.x[2])),
    ];
    // Spatial moment of the covector f for Ψ: m = T⁻ᵀ f is material, R m spatial.
    let spatial = |q: &Vector6<f64>, v: &Vector6<f64>, a: &Vector6<f64>| {
        let (r, ..) = all(&eccentric(), q.as_slice(), v.as_slice(), a.as_slice()).unwrap();
        let psi = Vector3::new(q[3], q[4], q[5]);
        let f = Vector3::new(r[3], r[4], r[5]);
        let m = so3::rotation(&psi) * (so3::tangent_inverse(&psi).transpose() * f);
        (Vector3::new(r[0], r[1], r[2]), m)
    };
    let (force, moment) = spatial(&q, &v, &a);
    let (force_after, moment_after) = spatial(&moved[0], &moved[1], &moved[2]);
    assert!((Q * force - force_after).norm() < 1e-13);
    assert!((Q * moment - moment_after).norm() < 1e-13);
}

#[test]
fn inertia_has_components_in_any_frame() {
    // The same body from data in its own axes R0 and from data in global ones.
    let R0 = so3::rotation(&Vector3::new(-0.8, 0.3, 1.9));
    let c = R0.transpose() * Vector3::from(CENTER);
    let J = R0.transpose() * inertia() * R0;
    let own = Inertia::about_centre(1.7, c, J).rotated(&R0);
    let global = eccentric();
    let global = global.inertia();
    assert!((own.S - global.S).norm() < 1e-14);
    assert!((own.J - global.J).norm() < 1e-14);
    // A point mass at c has the inertia −m c~c~.
    let point = Inertia::about_centre(2.0, c, Matrix3::zeros());
    let expected = so3::skew(&c) * so3::skew(&c) * -2.0;
    assert!((point.J - expected).norm() < 1e-14);
}

#[test]
fn a_body_refuses_the_edge_of_the_chart() {
    let edge = std::f64::consts::TAU - 1e-4;
    let x = [0.0, 0.0, 0.0, 0.0, edge, 0.0];
    let error = all(&eccentric(), &x, &[0.0; 6], &[0.0; 6]).unwrap_err();
    let refused = matches!(error, DomainError::Beyond { limit, margin } if limit == CHART_EDGE && margin <= 0.0);
    assert!(refused, "{error}");
}
