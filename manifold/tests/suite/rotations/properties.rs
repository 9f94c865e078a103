//! Properties of rotation vectors, drawn from the whole of their chart.

#![allow(non_snake_case)]

use approx::{assert_abs_diff_eq, assert_relative_eq};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use pullback_manifold::so3::{complement, log_quaternion, log_rotation, quaternion, rotation};
use std::f64::consts::{PI, TAU};

/// Vectors in all directions, with angles from `range` evenly and close to its lower end.
fn vectors(range: std::ops::Range<f64>) -> impl Strategy<Value = Vector3<f64>> {
    let (least, most) = (range.start.max(1e-100), range.end);
    let angle = prop_oneof![
        range,
        (0.0..1.0_f64).prop_map(move |u| least * (most / least).powf(u)),
    ];
    let side = -1.0..1.0_f64;
    let direction = [side.clone(), side.clone(), side].prop_map(Vector3::from);
    let direction = direction.prop_filter("a direction", |v| v.norm() > 0.1);
    (direction, angle).prop_map(|(v, psi)| v.normalize() * psi)
}

/// The same draws every time.
fn config() -> ProptestConfig {
    ProptestConfig {
        cases: 300,
        rng_seed: RngSeed::Fixed(38),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn the_logarithm_inverts_the_exponential_in_the_open_ball(Psi in vectors(0.0..PI)) {
        prop_assume!(Psi.norm() < PI);
        let psi = Psi.norm();
        assert_abs_diff_eq!(log_quaternion(&quaternion(&Psi)), Psi, epsilon = 1e-14 * psi);
        // The entries of a matrix are of order one: accurate in absolute terms from there on.
        let log = log_rotation(&rotation(&Psi), &Vector3::zeros());
        assert_abs_diff_eq!(log, Psi, epsilon = 1e-14 * psi.min(1.0));
    }

    #[test]
    fn rotations_are_orthogonal_and_turn_about_their_vector(Psi in vectors(0.0..TAU)) {
        let R: Matrix3<f64> = rotation(&Psi);
        assert_abs_diff_eq!(R.transpose() * R, Matrix3::identity(), epsilon = 1e-14);
        assert_relative_eq!(R.determinant(), 1.0, epsilon = 0.0, max_relative = 1e-14);
        assert_relative_eq!(R.trace(), 1.0 + 2.0 * Psi.norm().cos(), epsilon = 1e-14);
        assert_abs_diff_eq!(R * Psi, Psi, epsilon = 1e-14 * Psi.norm());
        assert_abs_diff_eq!(rotation(&-Psi), R.transpose(), epsilon = 1e-15);
    }

    /// Ψ and Ψᶜ = Ψ − 2π e are one rotation, alone and before any other.
    #[test]
    fn composition_does_not_see_which_of_two_complements(
        Psi in vectors(0.01..TAU),
        other in vectors(0.0..TAU),
    ) {
        prop_assume!(Psi.norm() < TAU - 0.01);
        let back = complement(&Psi);
        assert_relative_eq!((Psi - back).norm(), TAU, epsilon = 0.0, max_relative = 1e-14);
        assert_abs_diff_eq!(complement(&back), Psi, epsilon = 1e-14);
        assert_abs_diff_eq!(rotation(&back), rotation(&Psi), epsilon = 1e-14);
        assert_abs_diff_eq!(
            rotation(&Psi) * rotation(&-back),
            Matrix3::identity(),
            epsilon = 1e-14
        );
        let product = |Psi: &Vector3<f64>| quaternion(Psi).product(&quaternion(&other));
        let (one, two) = (product(&Psi), product(&back).opposite());
        assert_abs_diff_eq!(one.w, two.w, epsilon = 1e-14);
        assert_abs_diff_eq!(one.v, two.v, epsilon = 1e-14);
        assert_abs_diff_eq!(
            one.rotation(),
            rotation(&Psi) * rotation(&other),
            epsilon = 1e-14
        );
    }
}
