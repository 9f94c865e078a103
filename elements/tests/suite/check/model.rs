//! `check::model`: a right model passes from many seeds, whatever its units and stiffness ratios.

use crate::support::*;

/// Everything at once: beams of two orders, a body on a revolute joint and a rigid link, a ball
/// joint, a slide, springs, a bushing, loads of all kinds and a driven support.
fn everything() -> Context {
    let mut b = ModelBuilder::new();
    let inertia = Inertia::about_centre(
        0.7,
        Vector3::new(0.0, 0.02, 0.01),
        Matrix3::from_diagonal(&Vector3::new(0.03, 0.02, 0.015)),
    );
    let [root, corner, tip] = frame_model(&mut b, Some(inertia));
    let hinge = Revolute::new([1.0, 2.0, -1.0]).unwrap();
    let hinge = b.attach("hinge", tip, hinge).unwrap();
    let far = b.offset("far", hinge.frame, [0.1, 0.2, 0.3]).unwrap();
    let J = Matrix3::from_diagonal(&Vector3::new(0.2, 0.3, 0.4));
    let body = RigidBody::new(2.0, J, Vector3::new(0.05, 0.0, 0.1)).unwrap();
    b.element("body", body, &[far]).unwrap();
    let weight = body.weight([0.0, 0.0, -9.81], Constant(1.0));
    b.element("weight", weight, &[far]).unwrap();
    let spring = CoordinateSpring::new(LAW).unwrap();
    b.element("torsion", spring, &[hinge.coordinates[0]])
        .unwrap();
    let ball = b.attach_free("ball", corner, Spherical).unwrap();
    b.element("ball body", body, &[ball.frame]).unwrap();
    let cross = Universal::new([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).unwrap();
    let cross = b.attach("cross", tip, cross).unwrap();
    b.element("cross body", body, &[cross.frame]).unwrap();
    let leg = b.find("leg/1").unwrap();
    let runner = b
        .slide("runner", &[corner, leg, tip], 0.3, Interpolation::Total)
        .unwrap();
    b.element("runner body", body, &[runner.frame]).unwrap();
    let positions = [tip, root].map(|n| b.position(n));
    let rope = AxialSpring::new(&positions, 4.0, 0.3).unwrap();
    b.element("rope", rope, &[tip, root]).unwrap();
    let positions = [far, root].map(|n| b.position(n));
    let K = Matrix6::from_diagonal(&[5.0, 6.0, 7.0, 0.5, 0.6, 0.7].into());
    let mount = Bushing::new(&positions, &Matrix3::identity(), &K, &(K * 0.1)).unwrap();
    b.element("mount", mount, &[far, root]).unwrap();
    b.support(root, &[Dof::X, Dof::Y, Dof::RX, Dof::RY]);
    b.prescribe(root, Dof::Z, sine(0.2));
    b.prescribe(root, Dof::RZ, sine(0.5));
    Context::new(b.build().unwrap())
}

#[test]
fn a_right_model_passes_from_many_seeds() {
    let mut model = everything();
    for seed in 0..12 {
        let options = seeded(seed);
        let report = check::model(&mut model, &options);
        report.assert();
        assert!(report.rows().len() > 200, "{}", report.rows().len());
    }
}

/// A cantilever of slenderness 1e5 in millimetres and newtons: stiffnesses from 1e-4 to 1e6, a soft
/// spring and a body of grams at its end.
#[test]
fn stiffness_ratios_of_ten_orders_and_millimetres_raise_no_alarm() {
    for (length, EA, EI) in [
        (1000.0, 1e6, 1e-4 * 1e6),
        (1e-3, 1e10, 1.0),
        (1.0, 1e10, 1.0),
    ] {
        let mut b = ModelBuilder::new();
        let root = b.node("root", [5.0 * length, 0.0, 0.0]).unwrap();
        let tip = b.node("tip", [6.0 * length, 0.0, 0.0]).unwrap();
        let EI = EI * length * length;
        let J = Matrix3::from_diagonal(&Vector3::new(2.0, 1.0, 1.0)) * (1e-6 * length * length);
        let section = Section::diagonal(EA, [0.4 * EA; 2], EI, [EI, 2.0 * EI]).unwrap();
        let section = section.with_mass(1e-6, J);
        lay_twisted(&mut b, "rod", [root, tip], [4, 1], section, 0.2);
        b.support(root, &Dof::ALL);
        let J = Matrix3::from_diagonal(&Vector3::new(1.0, 1.5, 2.0)) * (1e-7 * length * length);
        let body = RigidBody::new(1e-6, J, Vector3::zeros()).unwrap();
        b.element("tip mass", body, &[tip]).unwrap();
        let soft = AxialSpring::new(&[root, tip].map(|n| b.position(n)), 1e-10 * EA, 0.0).unwrap();
        b.element("soft", soft, &[root, tip]).unwrap();
        let mut context = Context::new(b.build().unwrap());
        for seed in 0..8 {
            check::model(&mut context, &seeded(seed)).assert();
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_report_and_states_outside_are_told() {
    let mut model = everything();
    let options = ModelOptions::default();
    let first = check::model(&mut model, &options);
    assert_eq!(first, check::model(&mut model, &options));
    assert_ne!(first, check::model(&mut model, &seeded(1)));
    // The slide is beyond the end of its chain.
    let way = model.find("runner arc_length").unwrap();
    let mut q = vec![0.0; pullback_manifold::system::System::pattern(&model).dim()];
    q[model.unknown_at(way, 0).unwrap()] = 100.0;
    let report = check::model(&mut model, &ModelOptions { q, ..options });
    assert!(!report.is_ok());
    assert!(report.to_string().contains("runner"), "{report}");
}
