//! Forces per length: what they add up to on a straight element of length 1.5.

use crate::support::*;

const FORCE: [f64; 3] = [1.0, -2.0, 4.0];

/// Equidistant nodes along e1.
fn positions(nodes: usize) -> Vec<Vector3<f64>> {
    (0..nodes)
        .map(|i| Vector3::new(1.5 * i as f64 / (nodes - 1) as f64, 0.0, 2.0))
        .collect()
}

/// The sums over all nodes.
fn resultant(r: &DVector<f64>) -> Vector6<f64> {
    Vector6::from_fn(|k, _| r.iter().skip(k).step_by(6).sum())
}

#[test]
fn a_line_load_adds_up_to_force_times_length() {
    for nodes in 2..=4 {
        let positions = positions(nodes);
        let load = LineLoad::new(&positions, FORCE, false, Constant(1.0));
        let (r, _) = forces(&load.unwrap(), &moving(&vec![0.2; 6 * nodes], &[], &[])).unwrap();
        let gap = resultant(&r) - Vector6::new(1.5, -3.0, 6.0, 0.0, 0.0, 0.0);
        assert!(gap.norm() < 1e-14, "{nodes} nodes: {gap}");
        // The resultant acts at the middle.
        let arms = positions.iter().zip(r.as_slice().chunks(6));
        let moment: f64 = arms.map(|(p, r)| p.x * r[1]).sum();
        let gap = moment + 3.0 * 0.75;
        assert!(gap.abs() < 1e-14, "{nodes} nodes: {moment}");
    }
    let one = LineLoad::new(&positions(2)[..1], FORCE, false, Constant(1.0));
    assert_eq!(one.unwrap_err(), BeamError::Nodes(1));
}

#[test]
fn a_follower_line_load_turns_with_a_rigid_rotation() {
    // By π/2 about e3, and by 2π/3 about the diagonal of a cube, which changes the axes in a circle.
    let third = 2.0 * PI / 27.0_f64.sqrt();
    for (psi, turned) in [
        ([0.0, 0.0, 0.5 * PI], [2.0, 1.0, 4.0]),
        ([third; 3], [4.0, 1.0, -2.0]),
    ] {
        for nodes in 2..=4 {
            for interpolation in [Interpolation::Total, Interpolation::Geodesic] {
                let load = LineLoad::new(&positions(nodes), FORCE, true, Constant(2.0));
                let load = load.unwrap().with_interpolation(interpolation);
                let x = [[0.2; 3], psi].concat().repeat(nodes);
                let (r, _) = forces(&load, &moving(&x, &[], &[])).unwrap();
                let [x, y, z] = turned;
                let expected = Vector6::new(x, y, z, 0.0, 0.0, 0.0) * (2.0 * 1.5);
                let gap = resultant(&r) - expected;
                assert!(gap.norm() < 2e-14, "{nodes} nodes: {gap}");
            }
        }
    }
}
