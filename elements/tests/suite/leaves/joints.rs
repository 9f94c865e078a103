//! Joints: every law of their maps.

use crate::support::*;
use pullback_manifold::so3::{self, Quaternion};

#[test]
fn every_joint_obeys_the_laws_of_a_map() {
    let c = Vector3::new(0.4, -1.1, 0.7);
    check::joint(&Offset { c }).assert();
    check::joint(&Revolute::new([1.0, -2.0, 0.5]).unwrap()).assert();
    check::joint(&Rheonomic).assert();
    let positions = [[0.0; 3], [1.0, 0.2, 0.0], [2.0, 0.0, 0.5]].map(Vector3::from);
    for interpolation in [Interpolation::Total, Interpolation::Geodesic] {
        let chain = Chain::new(&positions, 1.2).unwrap();
        check::map(&Slide::new(chain, interpolation)).assert();
    }
}

/// A table that is moved by a function of time, on which something slides and turns.
#[derive(Clone)]
struct Rheonomic;

impl Joint<2> for Rheonomic {
    fn pose<S: Scalar>(&self, t: S, q: &SVector<S, 2>) -> Pose<S> {
        let (x, z) = (Vector3::x(), Vector3::z());
        Pose::identity()
            .translated(&Vector3::new((t * 2.0).sin(), t * t, q[0]))
            .rotated(&Quaternion::about(&z, t * 1.3 + q[0] * q[1]))
            .translated(&x.map(S::constant))
            .rotated(&Quaternion::about(&x, q[1]))
    }

    fn coordinates(&self) -> [JointCoordinate; 2] {
        [("u", Quantity::Length), ("a", Quantity::Angle)]
    }
}

#[test]
fn laws_hold_on_the_other_branch_too() {
    let mut map = JointMap::new(Revolute::new([1.0, -2.0, 0.5]).unwrap()).between_charts();
    let q = [0.1, 0.2, 0.3, 0.5, -0.4, 0.8, 3.4];
    let psi =
        |map: &MapGraph| Vector3::from_column_slice(&check::motion(map, 0.0, [&q; 3])[0][3..]);
    let before = psi(&map);
    assert!(map.change_charts(0.0, &q).charts == 1);
    assert!((so3::complement(&before) - psi(&map)).norm() < 1e-14);
    check::parametrization(&map).assert();
}

#[test]
#[should_panic(expected = "a graph reads one segment")]
fn a_graph_refuses_a_slide() {
    let chain = Chain::new(&[Vector3::zeros(), Vector3::x()], 0.5).unwrap();
    let slide = Slide::new(chain, Interpolation::Total);
    MapGraph::new(13).add(Box::new(slide), vec![(Read::Input(0), 13)]);
}

#[test]
fn joints_whose_children_turn_freely_obey_the_laws_of_a_map() {
    check::parametrization(
        &JointMap::turning_freely(Offset {
            c: Vector3::zeros(),
        })
        .between_charts(),
    )
    .assert();
    check::parametrization(&JointMap::turning_freely(Rheonomic).between_charts()).assert();
}
