//! Bodies: their laws, their kinetic energy and inertia.

use crate::support::*;

/// A symmetric inertia with principal moments 2.5, 3, 4 and axes that are not the global ones.
fn inertia() -> Matrix3<f64> {
    let R = so3::rotation(&Vector3::new(0.4, -0.7, 1.1));
    R * Matrix3::from_diagonal(&Vector3::new(2.5, 3.0, 4.0)) * R.transpose()
}

const CENTER: [f64; 3] = [0.3, -0.5, 0.8];

/// A body whose node is not its centre of mass.
fn eccentric() -> RigidBody {
    RigidBody::new(1.7, inertia(), CENTER.into()).unwrap()
}

fn centred() -> RigidBody {
    RigidBody::new(1.7, inertia(), Vector3::zeros()).unwrap()
}

#[test]
fn bodies_obey_the_laws_of_elements() {
    check::element(&eccentric()).assert();
    check::element(&centred()).assert();
    check::element(&PointMass::new(2.5).unwrap()).assert();
    let wheel = RigidBody::new(0.0, inertia(), CENTER.into()).unwrap();
    check::element(&wheel).assert();
}

#[test]
fn there_is_no_kinetic_energy_in_statics() {
    let q: Vector6<f64> = Random::new(4).vector();
    let at = moving(q.as_slice(), &[], &[]);
    let body = eccentric();
    let in_charts = check::InCharts(&body);
    assert_eq!(in_charts.abilities().kinetic_energy(&at), Some(0.0));
    let mass = PointMass::new(2.0).unwrap();
    assert_eq!(mass.kinetic_energy(&at), Some(0.0));
}

#[test]
fn inertia_has_components_in_any_frame() {
    // The same body from data in its own axes R0 and from data in global ones.
    let R0 = so3::rotation(&Vector3::new(-0.8, 0.3, 1.9));
    let c = R0.transpose() * Vector3::from(CENTER);
    let J = R0.transpose() * inertia() * R0;
    let own = Inertia::about_centre(1.7, c, J).rotated(&R0);
    let global = eccentric();
    let global = global.inertia();
    assert!((own.S - global.S).norm() < 1e-14);
    assert!((own.J - global.J).norm() < 1e-14);
    // A point mass at c has the inertia −m c~c~.
    let point = Inertia::about_centre(2.0, c, Matrix3::zeros());
    let expected = so3::skew(&c) * so3::skew(&c) * -2.0;
    assert!((point.J - expected).norm() < 1e-14);
}
