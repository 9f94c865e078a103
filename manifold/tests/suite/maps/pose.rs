//! Frames by their charts and by their poses.

use crate::support::*;
use nalgebra::Vector6;
use pullback_manifold::map::pose::orientation;
use pullback_manifold::so3::{self, Quaternion};

/// Rotation angles on both branches of the rotation vector.
const ANGLES: [f64; 7] = [0.0, 1e-8, 1.1, PI - 1e-6, PI + 1e-6, 4.0, 6.2];

fn random_motion(random: &mut Random, angle: f64) -> [Vector6<f64>; 3] {
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
        let motion = random_motion(&mut random, angle);
        // T⁻¹ grows without bound towards a whole turn.
        let size = (1.0 + angle) / (1.0 - angle / TAU).powi(3);
        let found = check::motion(&graph, 0.3, motion.each_ref().map(|x| x.as_slice()));
        for (found, expected) in found.iter().zip(&motion) {
            let what = format!("motion at {angle}");
            near(found, expected.as_slice(), size, &what);
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
        let [q, v, a] = random_motion(&mut random, angle);
        let psi = Vector3::from_fn(|i, _| Moving::<0>::given([q[3 + i], v[3 + i], a[3 + i]]));
        let R = so3::rotation(&psi);
        let [R, R_dot, R_ddot] = [0, 1, 2].map(|k| R.map(|r| r.x[k]));
        let [x, x_dot, x_ddot, ..] =
            check::motion(&ToPose, 0.3, [&q, &v, &a].map(|x| x.as_slice()));
        let turn = orientation(&x).rotation();
        near(turn.as_slice(), R.as_slice(), 1.0, "R");
        // R̈ Rᵀ = ω̇~ + ω~ω~, of which the square is symmetric.
        for (rate, R_rate) in [(&x_dot, R_dot), (&x_ddot, R_ddot)] {
            let turn = R_rate * R.transpose();
            let skew = (turn - turn.transpose()) * 0.5;
            let right = so3::skew(&Vector3::from_column_slice(&rate[3..]));
            near(right.as_slice(), skew.as_slice(), 10.0, "omega");
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
    let back = Quaternion::from_rodrigues(&whole.rodrigues());
    assert!(back.w < 0.0 && back.v.norm() < 1e-15, "{back:?}");
}
