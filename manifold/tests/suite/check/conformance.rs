//! One line per leaf, and the joints of the theory branch against an independent implementation.

#![allow(non_snake_case)]

use crate::support::{Offset, Revolute, matrix, reference, relative, vector};
use nalgebra::{SVector, Vector3};
use pullback_conformance as check;
use pullback_manifold::chart::{Complement, RotationVector, WienerMilenkovic};
use pullback_manifold::map::{Increment, Map};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3;

const EXACT: f64 = 1e-12;

/// q ↦ a pendulum on a driven cart: a map that knows the time.
#[derive(Clone)]
struct Driven;

impl Map<2, 3> for Driven {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, 2>) -> SVector<S, 3> {
        let cart = (t * 2.0).sin() * q[0];
        Vector3::new(
            cart + q[1].sin(),
            q[1].cos() * (t + 1.0),
            q[0] * q[1] * t * t,
        )
    }
}

/// Parent node and angle ↦ the dependent's frame: a revolute joint after an offset.
#[derive(Clone)]
struct HingeAtEnd;

impl Map<7, 6> for HingeAtEnd {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, 7>) -> SVector<S, 6> {
        let offset = Offset([0.4, -0.2, 0.7]).phi(t, &q.fixed_rows::<6>(0).into_owned());
        let revolute = Revolute {
            axis: Vector3::new(0.6, 0.0, 0.8),
        };
        let psi = revolute.phi(t, &SVector::<S, 4>::new(q[3], q[4], q[5], q[6]));
        SVector::<S, 6>::new(offset[0], offset[1], offset[2], psi[0], psi[1], psi[2])
    }
}

#[test]
fn charts() {
    check::chart(&RotationVector).assert();
    check::chart(&WienerMilenkovic).assert();
}

#[test]
fn maps() {
    check::map(&Complement).assert();
    check::map(&Driven).assert();
    let turn = Vector3::new(0.4, -1.1, 0.7);
    check::map(&Increment::<6>::from(&turn)).assert();
    check::map(&Increment::<3>::from(&turn)).assert();
    check::map(&Offset([0.3, 1.2, -0.5])).assert();
    check::map(&HingeAtEnd).assert();
}

#[test]
fn revolute_joint() {
    let axis = Vector3::new(2.0, -1.0, 2.0) / 3.0;
    check::map(&Revolute { axis }).assert();
}

/// Everything a map offers against one row of the reference file.
fn against_reference<M: Map<D, N>, const D: usize, const N: usize>(
    map: &M,
    row: &serde_json::Value,
) {
    let (q, v, a) = (
        vector::<D>(&row["q"]),
        vector::<D>(&row["q_dot"]),
        vector::<D>(&row["q_ddot"]),
    );
    let k = map.kinematics(0.0, &q, &v, &a);
    relative("x", &k.x, &vector::<N>(&row["x"]), EXACT);
    relative("x_dot", &k.x_dot, &vector::<N>(&row["x_dot"]), EXACT);
    relative("x_ddot", &k.x_ddot, &vector::<N>(&row["x_ddot"]), EXACT);
    relative("B", &k.B, &matrix::<N, D>(&row["B"]), EXACT);
    relative("B_dot", &k.B_dot, &matrix::<N, D>(&row["B_dot"]), EXACT);
    relative("B_ddot", &k.B_ddot, &matrix::<N, D>(&row["B_ddot"]), EXACT);
    relative(
        "K_sigma",
        &map.geometric_stiffness(0.0, &q, &vector::<N>(&row["f"])),
        &matrix::<D, D>(&row["K_sigma"]),
        EXACT,
    );
}

#[test]
fn offset_is_that_of_the_reference() {
    let rows = reference("offset");
    assert_eq!(rows.len(), 4);
    for row in &rows {
        let c = vector::<3>(&row["offset"]);
        against_reference(&Offset(c.into()), row);
    }
}

#[test]
fn revolute_is_that_of_the_reference() {
    let rows = reference("revolute");
    assert_eq!(rows.len(), 2);
    for row in &rows {
        let axis = vector::<3>(&row["axis"]);
        against_reference(&Revolute { axis }, row);
    }
}

#[test]
fn complement_is_that_of_the_reference() {
    let rows = reference("switching");
    assert_eq!(rows.len(), 4);
    for row in &rows {
        let (q, v, a) = (
            vector::<3>(&row["psi"]),
            vector::<3>(&row["psi_dot"]),
            vector::<3>(&row["psi_ddot"]),
        );
        let k = Complement.kinematics(0.0, &q, &v, &a);
        relative("x", &k.x, &vector::<3>(&row["psi_complement"]), EXACT);
        relative("B", &k.B, &matrix::<3, 3>(&row["B"]), EXACT);
        relative("B_dot", &k.B_dot, &matrix::<3, 3>(&row["B_dot"]), EXACT);
        relative("B_ddot", &k.B_ddot, &matrix::<3, 3>(&row["B_ddot"]), EXACT);
        relative(
            "K_sigma",
            &Complement.geometric_stiffness(0.0, &q, &vector::<3>(&row["f"])),
            &matrix::<3, 3>(&row["K_sigma"]),
            EXACT,
        );
    }
}

#[test]
fn offset_closed_forms_are_those_of_the_thesis() {
    // [M04] (197) is not the code's way (exact differentiation is), so it is an independent check.
    let c = Vector3::new(0.3, 1.2, -0.5);
    let mut random = check::Random::new(11);
    for _ in 0..20 {
        let q: SVector<f64, 6> = random.vector();
        let f: SVector<f64, 6> = random.vector();
        let psi = q.fixed_rows::<3>(3).into_owned();
        let quotients = pullback_manifold::quotients::Quotients::new(psi.norm());
        let (R, T) = (so3::rotation(&psi), so3::tangent(&psi));
        let force = R.tr_mul(&f.fixed_rows::<3>(0).into_owned());
        let expected = so3::C2(&c.cross(&force), &psi, &quotients)
            + T.transpose() * so3::skew(&c) * so3::skew(&force) * T;
        let K = Offset(c.into()).geometric_stiffness(0.0, &q, &f);
        relative(
            "K_sigma",
            &K.fixed_view::<3, 3>(3, 3).into_owned(),
            &expected,
            EXACT,
        );
        let B = Offset(c.into()).tangent(0.0, &q).B;
        relative(
            "B",
            &B.fixed_view::<3, 3>(0, 3).into_owned(),
            &(R * so3::skew(&c) * T * -1.0),
            EXACT,
        );
    }
}
