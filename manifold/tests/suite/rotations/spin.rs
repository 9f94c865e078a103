//! Rates of rotation vectors from spins, against their definitions.

use crate::support::*;
use pullback_manifold::so3::{Spin, T_dot_psi_dot, VelocityKind, rotation, tangent};

fn cases() -> [[Vector3<f64>; 3]; 4] {
    let [Omega, Omega_dot] = [Vector3::new(1.1, -0.4, 0.7), Vector3::new(-2.0, 0.3, 1.6)];
    [
        Vector3::zeros(),
        Vector3::new(1e-8, -2e-8, 1e-8),
        Vector3::new(0.3, -0.5, 0.2),
        Vector3::new(-1.4, 1.2, 2.0),
    ]
    .map(|theta| [theta, Omega, Omega_dot])
}

#[test]
fn rates_give_the_spins_that_they_come_from() {
    for [theta, Omega, Omega_dot] in cases() {
        let s = Spin::rates(VelocityKind::Material, &theta, &Omega, &Omega_dot);
        let T = tangent(&theta);
        let more = T_dot_psi_dot(&s.theta_dot, &theta, &Quotients::new(theta.norm()));
        assert!((T * s.theta_dot - Omega).norm() < 1e-14);
        assert!((T * s.theta_ddot + more - Omega_dot).norm() < 1e-13);
        // The same motion by its spatial spins: w = R Ω, and ẇ = R (Ω̇ + Ω×Ω).
        let R = rotation(&theta);
        let [w, w_dot] = [R * Omega, R * Omega_dot];
        // And with the rate in the body beside the velocity in the frame.
        for (kind, rate) in [
            (VelocityKind::Spatial, w_dot),
            (VelocityKind::Mixed, Omega_dot),
        ] {
            let other = Spin::rates(kind, &theta, &w, &rate);
            assert!((other.theta_dot - s.theta_dot).norm() < 1e-14);
            assert!((other.theta_ddot - s.theta_ddot).norm() < 1e-13);
        }
    }
}

#[test]
fn their_variation_is_their_derivative() {
    let all = [
        VelocityKind::Material,
        VelocityKind::Spatial,
        VelocityKind::Mixed,
    ];
    let cases = cases().into_iter().flat_map(|case| all.map(|s| (s, case)));
    for (spins, [theta, Omega, Omega_dot]) in cases {
        let spin = Spin::rates(spins, &theta, &Omega, &Omega_dot);
        for numbers in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, -1.2, 0.8]] {
            let [K, C, M] = numbers;
            let along = |e: &Vector3<f64>| {
                let (Omega, Omega_dot) = (Omega + e * C, Omega_dot + e * M);
                Spin::rates(spins, &(theta + e * K), &Omega, &Omega_dot)
            };
            let found = spin.varied(numbers, &theta);
            // Central differences extrapolated once after Richardson: an error of h⁴.
            let mut expected = [Matrix3::zeros(); 2];
            for k in 0..3 {
                let slope = |h: f64| {
                    let e = Vector3::ith(k, h);
                    let (a, b) = (along(&e), along(&-e));
                    [a.theta_dot - b.theta_dot, a.theta_ddot - b.theta_ddot].map(|d| d / (2.0 * h))
                };
                let (coarse, fine) = (slope(2e-3), slope(1e-3));
                for i in 0..2 {
                    expected[i].set_column(k, &((fine[i] * 4.0 - coarse[i]) / 3.0));
                }
            }
            for (found, expected) in found.iter().zip(&expected) {
                assert!((found - expected).norm() < 1e-8, "{numbers:?} at {theta}");
            }
        }
    }
}

/// A velocity and an acceleration after a change of the coordinates q = θ of an increment.
fn rewritten(
    map: &mut Increment<3>,
    q: &Vector3<f64>,
    [v, a]: [Vector3<f64>; 2],
) -> [Vector3<f64>; 2] {
    let (mut q, mut v, mut a) = (*q, v, [a.as_slice().to_vec()]);
    assert!(map.reparametrize(0.0, q.as_mut_slice(), v.as_mut_slice(), &mut a));
    assert_eq!(q, Vector3::zeros());
    [v, Vector3::from_column_slice(&a[0])]
}

#[test]
fn an_increment_remembers_where_it_is_centred() {
    let q = Vector3::new(0.3, -0.2, 0.5);
    let rates = [Vector3::new(1.0, 2.0, 3.0), Vector3::new(-0.4, 0.9, 0.2)];
    let [v, a] = rates;
    let mut one = Increment::with_velocities(VelocityKind::Material);
    // The first rewriting takes rates of coordinates to spins, later ones leave spins alone.
    assert_eq!(one.velocity_kind(), None);
    let [new, _] = rewritten(&mut one, &q, rates);
    assert!((new - tangent(&q) * v).norm() < 1e-15);
    assert_eq!(one.velocity_kind(), Some(VelocityKind::Material));
    assert_eq!(rewritten(&mut one, &q, rates), rates);
    // Spatial ones stay where they are: seen from the new Rₙ they have turned back.
    let mut spatial = Increment::with_velocities(VelocityKind::Spatial);
    rewritten(&mut spatial, &q, rates);
    let new = rewritten(&mut spatial, &q, rates);
    assert!((rotation(&q) * new[0] - v).norm() < 1e-14);
    assert!((rotation(&q) * new[1] - a).norm() < 1e-14);
    // Of mixed ones the velocity turns back, and the rate in the body stays.
    let mut mixed = Increment::with_velocities(VelocityKind::Mixed);
    rewritten(&mut mixed, &q, rates);
    let new = rewritten(&mut mixed, &q, rates);
    assert!((rotation(&q) * new[0] - v).norm() < 1e-14);
    assert_eq!(new[1], a);
    // From its saved state another one goes on at the same position.
    let saved = one.save();
    let mut other = Increment::with_velocities(VelocityKind::Material);
    assert!(other.restore(&saved));
    assert_eq!(one, other);
    let R = rotation(&q) * rotation(&q) * rotation(&q);
    assert!((rotation(&other.phi(0.0, &q)) - R).norm() < 1e-14);
    for wrong in [&[][..], &[1.0, 0.0, 0.0], &[2.0, 0.0, 0.0, 0.0, 1.0]] {
        assert!(!other.restore(wrong), "{wrong:?}");
    }
    assert_eq!(one, other);
}
