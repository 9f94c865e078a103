//! One line per leaf, and the joints of the theory branch against an independent implementation.

#![allow(non_snake_case)]

use crate::support::{Offset, Revolute, matrix, reference, relative, vector};
use nalgebra::{SVector, Vector3};
use pullback_conformance as check;
use pullback_manifold::chart::{
    Circle, Complement, Either, Euclidean, Frame, Identity, Product, RotationVector,
};
use pullback_manifold::map::{Composed, Increment, Map};
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
    check::chart::<_, 1>(&Euclidean).assert();
    check::chart::<_, 5>(&Euclidean).assert();
    check::chart(&Circle).assert();
    check::chart(&RotationVector).assert();
    check::chart::<_, 6>(&Frame::default()).assert();
    check::chart::<_, 4>(&Product::<RotationVector, Circle, 3, 1>::default()).assert();
    check::chart::<_, 6>(&Product::<RotationVector, RotationVector, 3, 3>::default()).assert();
}

#[test]
fn maps() {
    check::map::<_, 2, 2>(&Identity).assert();
    check::map(&Complement).assert();
    check::map::<_, 6, 6>(&Product::<Identity, Complement, 3, 3>::default()).assert();
    check::map(&Either(Some(Complement))).assert();
    check::map::<_, 3, 3>(&Either::<Complement>(None)).assert();
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

#[test]
fn composed_maps() {
    // An offset from a parent whose rotation is stored in the other chart.
    check::map(&Composed {
        outer: Offset([0.3, 1.2, -0.5]),
        inner: Product::<Identity, Complement, 3, 3>::default(),
    })
    .assert();
    check::map::<_, 5, 3>(&Composed {
        outer: Complement,
        inner: AwayFromZero,
    })
    .assert();
    check::map::<_, 2, 3>(&Composed {
        outer: Driven,
        inner: Composed {
            outer: Identity,
            inner: DrivenPlane,
        },
    })
    .assert();
}

/// Stays where the complement exists: the composed map knows the domain of the inner map only.
#[derive(Clone)]
struct AwayFromZero;

impl Map<5, 3> for AwayFromZero {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, 5>) -> SVector<S, 3> {
        Vector3::new(
            (q[0] * q[4]).sin() + 2.5,
            (q[1] + t).cos() * 0.7,
            (q[2] - q[3]).atan() * t,
        )
    }
}

/// Two coordinates to two, nonlinear and dependent on time.
#[derive(Clone)]
struct DrivenPlane;

impl Map<2, 2> for DrivenPlane {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, 2>) -> SVector<S, 2> {
        SVector::<S, 2>::new(q[0] * q[1] + t * t, (q[0] * t).exp() + q[1])
    }
}

/// The composed map written as one φ, so that its derivatives never see the chain rule of operators.
#[derive(Clone)]
struct Whole;

impl Map<2, 3> for Whole {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, 2>) -> SVector<S, 3> {
        Driven.phi(t, &DrivenPlane.phi(t, q))
    }
}

#[test]
fn pull_back_of_the_pull_back_is_that_of_the_composed_map() {
    let composed = Composed {
        outer: Driven,
        inner: DrivenPlane,
    };
    let mut random = check::Random::new(3);
    for _ in 0..20 {
        let (q, v, a) = (random.vector(), random.vector(), random.vector());
        let f: Vector3<f64> = random.vector();
        let (one, two) = (
            composed.kinematics(0.6, &q, &v, &a),
            Whole.kinematics(0.6, &q, &v, &a),
        );
        relative("x", &one.x, &two.x, EXACT);
        relative("x_dot", &one.x_dot, &two.x_dot, EXACT);
        relative("x_ddot", &one.x_ddot, &two.x_ddot, EXACT);
        relative("B", &one.B, &two.B, EXACT);
        relative("B_dot", &one.B_dot, &two.B_dot, EXACT);
        relative("B_ddot", &one.B_ddot, &two.B_ddot, EXACT);
        relative(
            "K_sigma",
            &composed.geometric_stiffness(0.6, &q, &f),
            &Whole.geometric_stiffness(0.6, &q, &f),
            EXACT,
        );
    }
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
