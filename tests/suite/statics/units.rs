//! What has no length, or next to none, is solved in any unit (tests/suite/closures/units.rs: models of any size).

use crate::support::dynamics::{grounded, observed, revolute, spring, weighed};
use crate::support::prelude::*;
use crate::support::program::assert_close;
use nalgebra::Matrix6;

/// A pendulum that is a body with its centre of mass `arm` away from a hinge, which is all that has a
/// position; a mass that is held `far` away where that is not zero.
fn pendulum(arm: f64, far: f64, k: f64, g: [f64; 3]) -> (Context, NodeId) {
    let (mut b, ground) = grounded();
    let hinge = revolute(&mut b, "hinge", ground, [0.0, 1.0, 0.0]);
    let center = Vector3::new(0.0, 0.0, -arm);
    let body = RigidBody::new(1.0, Matrix3::zeros(), center).unwrap();
    weighed(&mut b, "body", hinge.frame, body, g.map(|g| g * arm));
    spring(&mut b, k * arm * arm, hinge.coordinates[0]);
    if far > 0.0 {
        let other = b.node("other", [far, 0.0, 0.0]).unwrap();
        b.element("mass", PointMass::new(1.0).unwrap(), &[other])
            .unwrap();
        b.support(other, &Dof::ALL);
    }
    (Context::new(b.build().unwrap()), hinge.coordinates[0])
}

/// Arms, and positions of another part that has nothing to do with them.
fn arms() -> impl Iterator<Item = (f64, f64)> {
    let arms = [1.0, 1e-3, 1e-6, 1e-9, 1e-12, 1e6];
    (arms.into_iter()).flat_map(|arm| [0.0, 1.0, 1e3, 1e9].map(|far| (arm, far)))
}

#[test]
fn what_hangs_at_one_place_knows_no_metre() {
    // k θ = m g l (…) with a weight along x and −z of the size of the spring: θ + cos θ + sin θ = 0.
    for (arm, far) in arms() {
        let (mut context, angle) = pendulum(arm, far, 9.81, [9.81, 0.0, -9.81]);
        equilibrium(&mut context, &StaticOptions::default()).unwrap();
        let [found, ..] = context.coordinate(angle, 0).unwrap();
        let gap = found + found.cos() + found.sin();
        assert!(gap.abs() < 1e-9, "{arm:e}, {far:e}: {gap:.1e}");
    }
}

#[test]
fn what_swings_at_one_place_knows_no_metre() {
    let swing = |arm: f64, far: f64| {
        let (mut context, angle) = pendulum(arm, far, 2.0, [0.0, 0.0, -9.81]);
        let u = context.unknown_at(angle, 0).unwrap();
        let n = context.initial().len();
        let (mut q, rest) = (vec![0.0; n], vec![0.0; n]);
        q[u] = 1.5;
        let options = DynamicOptions::new(1.3, 0.01);
        observed(&mut context, [&q, &rest], &options, &mut |_, _| ());
        let [theta, rate, _] = context.coordinate(angle, 0).unwrap();
        [theta, rate]
    };
    let expected = swing(1.0, 0.0);
    assert!(expected[0].abs() < 1.4, "a motion: {expected:?}");
    for (arm, far) in arms() {
        let found = swing(arm, far);
        for (found, expected) in found.into_iter().zip(expected) {
            assert_close(found, expected, 1e-9, format!("{arm:e}, {far:e}"));
        }
    }
}

#[test]
fn a_force_turned_by_a_bushing_is_followed_in_any_unit() {
    // A moment k_r (1, 1, 0) turns the end by the vector (1, 1, 0), and a force k_f e₂ that follows
    // it: the displacement is R e₂ by Rodrigues' formula.
    let psi = 2.0_f64.sqrt();
    let (s, c) = (psi.sin() / psi, (1.0 - psi.cos()) / 2.0);
    let expected = Vector3::new(c, 1.0 - c, s);
    for length in [1.0, 1e-9, 1e-3, 1e3, 1e9] {
        let (mut b, ground) = grounded();
        let end = b.node("end", [0.0; 3]).unwrap();
        let turning = length * length;
        let stiffness = [1.0, 1.0, 1.0, turning, turning, turning];
        let K = Matrix6::from_diagonal(&stiffness.into());
        let (here, axes) = ([Vector3::zeros(); 2], Matrix3::identity());
        let bushing = Bushing::new(&here, &axes, &K, &Matrix6::zeros()).unwrap();
        b.element("bushing", bushing, &[ground, end]).unwrap();
        let moment = [turning, turning, 0.0];
        for (name, which, load) in [
            ("moment", LoadKind::SpatialMoment, moment),
            ("force", LoadKind::FollowerForce, [0.0, length, 0.0]),
        ] {
            let load = NodalLoad::new(which, load, Proportional(1.0));
            b.element(name, load, &[end]).unwrap();
        }
        let mut context = Context::new(b.build().unwrap());
        equilibrium(&mut context, &StaticOptions::default()).unwrap();
        let found = Vector3::from_fn(|k, _| context.coordinate(end, k).unwrap()[0]) / length;
        let gap = (found - expected).norm();
        assert!(gap < 1e-8, "{length:e}: {gap:.1e}");
    }
}
