//! Joints: every law of their maps, closed forms against derived ones, reference tensors.

#![allow(non_snake_case)]

use crate::support::{numbers, reference};
use nalgebra::{DMatrix, SVector, Vector3, Vector6};
use pullback_conformance as check;
use pullback_elements::beam::Interpolation;
use pullback_elements::joint::{Chain, Joint, JointMap, Offset, Revolute, Slide, Spherical};
use pullback_manifold::map::Map;
use pullback_manifold::so3;

#[test]
fn every_joint_obeys_the_laws_of_a_map() {
    let c = Vector3::new(0.4, -1.1, 0.7);
    check::joint(&Offset { c }).assert();
    check::joint(&Revolute::new([1.0, -2.0, 0.5]).unwrap()).assert();
    check::joint(&Spherical).assert();
    let positions = [[0.0; 3], [1.0, 0.2, 0.0], [2.0, 0.0, 0.5]].map(Vector3::from);
    for interpolation in [Interpolation::Total, Interpolation::Geodesic] {
        let chain = Chain::new(&positions, 1.2).unwrap();
        check::map(&Slide::new(chain, interpolation)).assert();
    }
}

#[test]
fn laws_hold_on_the_other_sheet_too() {
    let joint = Revolute::new([1.0, -2.0, 0.5]).unwrap();
    let q = SVector::<f64, 7>::from_column_slice(&[0.1, 0.2, 0.3, 0.5, -0.4, 0.8, 3.4]);
    let mut map = JointMap::new(joint);
    let before = map.phi(0.0, &q);
    assert!(map.change_charts(0.0, &q).charts == 1);
    let after = map.phi(0.0, &q);
    let psi = |x: &Vector6<f64>| Vector3::new(x[3], x[4], x[5]);
    assert!((so3::complement(&psi(&before)) - psi(&after)).norm() < 1e-14);
    check::map(&map).assert();
}

#[test]
fn the_offset_of_the_reference() {
    for row in reference("offset") {
        let get = |key: &str| numbers(&row[key]);
        let six = |key: &str| SVector::<f64, 6>::from_column_slice(&get(key));
        let c = Vector3::from_column_slice(&get("offset"));
        let map = JointMap::new(Offset { c });
        let k = map.kinematics(0.0, &six("q"), &six("q_dot"), &six("q_ddot"));
        compare(&row, "B", &k.B);
        compare(&row, "B_dot", &k.B_dot);
        compare(&row, "B_ddot", &k.B_ddot);
        let K = map.geometric_stiffness(0.0, &six("q"), &six("f"));
        compare(&row, "K_sigma", &K);
    }
}

#[test]
fn the_revolute_joint_of_the_reference() {
    for row in reference("revolute") {
        let get = |key: &str| numbers(&row[key]);
        // The reference has the rotation and the angle alone.
        let seven = |key: &str| {
            let q = get(key);
            SVector::<f64, 7>::from_column_slice(&[0.0, 0.0, 0.0, q[0], q[1], q[2], q[3]])
        };
        let e: [f64; 3] = get("axis").try_into().expect("three");
        let joint = Revolute::new(e).unwrap();
        let map = JointMap::new(joint);
        let k = map.kinematics(0.0, &seven("q"), &seven("q_dot"), &seven("q_ddot"));
        let block = |B: &nalgebra::SMatrix<f64, 6, 7>| B.fixed_view::<3, 4>(3, 3).into_owned();
        compare(&row, "B", &block(&k.B));
        compare(&row, "B_dot", &block(&k.B_dot));
        compare(&row, "B_ddot", &block(&k.B_ddot));
        let f = get("f");
        let f = Vector6::new(0.3, -0.1, 0.8, f[0], f[1], f[2]);
        let K = map.geometric_stiffness(0.0, &seven("q"), &f);
        compare(&row, "K_sigma", &K.fixed_view::<4, 4>(3, 3).into_owned());
        assert!(joint.pose(0.0, &seven("q")).rotation.w > 0.0);
    }
}

fn compare<const R: usize, const C: usize>(
    row: &serde_json::Value,
    key: &str,
    found: &nalgebra::SMatrix<f64, R, C>,
) {
    let expected = crate::support::matrix(&row[key]);
    let found = DMatrix::from_column_slice(R, C, found.as_slice());
    let gap = (&found - &expected).amax() / (1.0 + expected.amax());
    assert!(gap < 1e-12, "{key}: {gap:e}\n{found}{expected}");
}
