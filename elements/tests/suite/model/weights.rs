//! Loads beside a node and on one coordinate: weights and motors.

use crate::support::*;

#[test]
fn loads_obey_the_laws_of_elements() {
    check::element(&CoordinateForce::new(sine(1.7))).assert();
    let (force, arm) = ([0.8, -1.4, 2.2], [0.4, 0.9, -0.3]);
    check::element(&EccentricForce::new(force, arm, sine(1.7))).assert();
}

#[test]
fn a_motor_turns_its_coordinate() {
    let motor = CoordinateForce::new(Constant(2.5));
    assert!(motor.properties().load);
    assert_eq!(residual(&motor, &[0.4], &[]).unwrap()[0], 2.5);
    assert_eq!(motor.abilities().energy(&moving(&[0.4], &[], &[])), -1.0);
}

#[test]
fn weights_act_at_the_centre_of_mass() {
    let g = [0.0, 0.0, -9.81];
    let c = Vector3::new(0.3, -0.5, 0.8);
    let body = RigidBody::new(2.0, Matrix3::identity(), c).unwrap();
    let weight = body.weight(g, Constant(1.0));
    assert!(weight.properties().load);
    let x = [0.1, 0.2, 0.3, 0.5, 1.1, -0.9];
    let r = residual(&weight, &x, &[]).unwrap();
    let [force, moment] = spatial(&x, r.as_slice());
    let n = Vector3::from(g) * 2.0;
    let arm = so3::rotation(&Vector3::new(0.5, 1.1, -0.9)) * c;
    assert!((force - n).norm() < 1e-14);
    assert!((moment - arm.cross(&n)).norm() < 1e-13);
    // m g times the height the centre of mass gains.
    let height = 0.3 + (arm - c).z;
    let in_charts = check::InCharts(&weight);
    let energy = in_charts.abilities().energy(&moving(&x, &[], &[]));
    assert!((energy - 2.0 * 9.81 * height).abs() < 1e-13);
    // A free body in the field falls with g and does not begin to turn: r = weight − M a = 0.
    let falling = moving(&x, &[0.0; 6], &[0.0, 0.0, -9.81, 0.0, 0.0, 0.0]);
    let (turning, _) = forces(&body, &falling).unwrap();
    assert!((turning + r).amax() < 1e-13);
    let mass = PointMass::new(2.0).unwrap();
    let r = residual(&mass.weight(g, Constant(0.5)), &x, &[]).unwrap();
    assert_eq!(r.as_slice(), [0.0, 0.0, -9.81, 0.0, 0.0, 0.0]);
}
