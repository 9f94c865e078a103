//! Frames by their charts and by their poses, and graphs of maps.

#![allow(non_snake_case)]

use crate::support::Offset;
use nalgebra::{SVector, Vector3, Vector6};
use pullback_conformance::{self as check, Random};
use pullback_manifold::jet::Moving;
use pullback_manifold::map::pose::orientation;
use pullback_manifold::map::{Map, MapGraph, Parametrization, Read, ToChart, ToPose, derived};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::{self, Quaternion};
use std::f64::consts::{PI, TAU};

/// Rotation angles on both branches of the rotation vector.
const ANGLES: [f64; 7] = [0.0, 1e-8, 1.1, PI - 1e-6, PI + 1e-6, 4.0, 6.2];

/// x and B with their rates.
fn kinematics<const D: usize>(
    map: &mut dyn Parametrization,
    motion: &[SVector<f64, D>; 3],
) -> [Vec<f64>; 6] {
    let n = map.dims().1;
    let mut out: [Vec<f64>; 6] = std::array::from_fn(|k| vec![0.0; if k < 3 { n } else { n * D }]);
    let [x, x_dot, x_ddot, B, B_dot, B_ddot] = out.each_mut().map(|x| &mut x[..]);
    let motion = motion.each_ref().map(|x| x.as_slice());
    map.evaluate(0.3, motion, &mut [[x, B], [x_dot, B_dot], [x_ddot, B_ddot]]);
    out
}

fn motion(random: &mut Random, angle: f64) -> [Vector6<f64>; 3] {
    let [mut q, v, a]: [Vector6<f64>; 3] = [(); 3].map(|()| random.vector());
    let psi = Vector3::new(0.6, -0.48, 0.64) * angle;
    q.fixed_rows_mut::<3>(3).copy_from(&psi);
    [q, v, a]
}

fn near(found: &[f64], expected: &[f64], size: f64, what: &str) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        let gap = (found - expected).abs();
        assert!(gap < 1e-11 * size, "{what}: {found} {expected}");
    }
}

#[test]
fn a_chart_comes_back_from_its_pose() {
    let mut graph = MapGraph::new(6);
    let pose = graph.add(Box::new(ToPose), vec![(Read::Input(0), 6)]);
    graph.add(Box::new(ToChart::default()), vec![(pose, 6)]);
    let mut graph = graph.with_outputs(1);
    let mut random = Random::default();
    for angle in ANGLES {
        let motion = motion(&mut random, angle);
        // T⁻¹ grows without bound towards a whole turn.
        let size = (1.0 + angle) / (1.0 - angle / TAU).powi(3);
        let found = kinematics(&mut graph, &motion);
        for (found, expected) in found.iter().zip(&motion) {
            near(
                found,
                expected.as_slice(),
                size,
                &format!("motion at {angle}"),
            );
        }
        let one = nalgebra::Matrix6::<f64>::identity();
        near(&found[3], one.as_slice(), size, "B");
        near(&found[4], &[0.0; 36], size, "B_dot");
        near(&found[5], &[0.0; 36], size, "B_ddot");
        let (f, mut K) = (random.vector::<6>(), [0.0; 36]);
        graph.geometric_stiffness(0.3, motion[0].as_slice(), f.as_slice(), &mut K);
        near(&K, &[0.0; 36], size, "K_sigma");
    }
    check::parametrization(&graph).assert();
}

#[test]
fn a_pose_moves_with_its_chart() {
    let mut random = Random::default();
    for angle in ANGLES {
        let [q, v, a] = motion(&mut random, angle);
        let psi = Vector3::from_fn(|i, _| Moving::<0>::given([q[3 + i], v[3 + i], a[3 + i]]));
        let R = so3::rotation(&psi);
        let [R, R_dot, R_ddot] = [0, 1, 2].map(|k| R.map(|r| r.x[k]));
        let [x, x_dot, x_ddot, ..] = kinematics(&mut ToPose, &[q, v, a]);
        near(
            orientation(&x).rotation().as_slice(),
            R.as_slice(),
            1.0,
            "R",
        );
        // R̈ Rᵀ = ω̇~ + ω~ω~, of which the square is symmetric.
        for (rate, R_rate) in [(&x_dot, R_dot), (&x_ddot, R_ddot)] {
            let turn = so3::axial(&(R_rate * R.transpose()));
            near(&rate[3..], turn.as_slice(), 10.0, "omega");
        }
    }
}

#[test]
fn modified_rodrigues_parameters_keep_the_sign_of_the_quaternion() {
    let e = Vector3::new(0.6, -0.48, 0.64);
    for angle in ANGLES.into_iter().chain([TAU - 1e-6, TAU - 1e-12]) {
        let turn = so3::quaternion(&(e * angle));
        let sigma = turn.rodrigues();
        assert_eq!(sigma.norm() > 1.0, turn.w < 0.0);
        let back = Quaternion::from_rodrigues(&sigma);
        assert!((back.w - turn.w).abs() < 1e-15, "{angle}");
        assert!(
            (back.v - turn.v).norm() < 1e-15 * (1.0 + turn.v.norm()),
            "{angle}"
        );
    }
    let whole = Quaternion {
        w: -1.0,
        v: Vector3::zeros(),
    };
    assert_eq!(whole.rodrigues(), Vector3::zeros());
}

/// A chain of two offsets beside a frame of its own, as one map: what the graph below composes.
#[derive(Clone)]
struct Composed(Offset, Offset);

impl Map<6, 12> for Composed {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, 6>) -> SVector<S, 12> {
        let first = self.0.phi(t, q);
        let second = self.1.phi(t, &first);
        SVector::from_fn(|i, _| if i < 6 { first[i] } else { second[i - 6] })
    }
}

#[test]
fn a_graph_has_the_derivatives_of_the_composed_map() {
    let [first, second] = [Offset([0.4, -1.1, 0.7]), Offset([-0.2, 0.5, 0.9])];
    let mut graph = MapGraph::new(6);
    let link = graph.add(first.clone().boxed(), vec![(Read::Input(0), 6)]);
    graph.add(second.clone().boxed(), vec![(link, 6)]);
    let mut graph = graph.with_outputs(2);
    let composed = Composed(first, second);
    let mut random = Random::default();
    for angle in [0.0, 1.1, 4.0] {
        let [q, v, a] = motion(&mut random, angle);
        let k = derived::kinematics(&composed, 0.3, &q, &v, &a);
        let found = kinematics(&mut graph, &[q, v, a]);
        let expected = [
            k.x.as_slice(),
            k.x_dot.as_slice(),
            k.x_ddot.as_slice(),
            k.B.as_slice(),
            k.B_dot.as_slice(),
            k.B_ddot.as_slice(),
        ];
        for (found, expected) in found.iter().zip(expected) {
            near(found, expected, 10.0, "kinematics");
        }
        let (f, mut K) = (random.vector::<12>(), [0.0; 36]);
        graph.geometric_stiffness(0.3, q.as_slice(), f.as_slice(), &mut K);
        let expected = derived::geometric_stiffness(&composed, 0.3, &q, &f);
        near(&K, expected.as_slice(), 10.0, "K_sigma");
    }
}
