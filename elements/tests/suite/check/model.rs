//! `check::model`: a right model passes from many seeds, whatever its units and stiffness ratios.

use crate::support::everything::everything;
use crate::support::*;

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

/// Nodes on both sides of half a turn, of which elements evaluate some in the other chart, and one that
/// stores the complement of its parent's rotation, where an element changes charts whatever the angle.
#[test]
fn a_right_model_passes_astride_a_change_of_chart() {
    let mut b = ModelBuilder::new();
    let positions = [
        [0.0; 3],
        [1.0, 0.0, 0.0],
        [1.9, 0.3, 0.0],
        [2.8, 0.2, 0.4],
        [2.0, 1.1, 0.3],
    ];
    let nodes = [0, 1, 2, 3].map(|k| b.node(format!("{k}"), positions[k]).unwrap());
    let seat = b.node("seat", positions[4]).unwrap();
    let twin = b.mapped_node("twin", positions[4], Twin.boxed(), &[seat]);
    let twin = twin.unwrap();
    let section = massive().with_damping(DAMPING).unwrap();
    lay(&mut b, "undamped", [nodes[0], nodes[1]], 1, 1, massive());
    for ends in [[nodes[1], nodes[2]], [nodes[2], nodes[3]], [nodes[2], twin]] {
        lay(&mut b, &format!("{ends:?}"), ends, 1, 1, section);
    }
    let ends = [positions[0], positions[1]].map(Vector3::from);
    let wind = LineLoad::new(&ends, [0.0, 2.0, 1.0], true, sine(2.0)).unwrap();
    b.element("wind", wind, &nodes[..2]).unwrap();
    for node in [nodes[0], seat] {
        b.prescribe(node, Dof::RY, sine(0.3));
    }
    let mut context = Context::new(b.build().unwrap());
    let mut q = vec![0.0; context.pattern().dim()];
    let e = Vector3::new(0.6, 0.0, -0.8);
    let angles = [2.7, 3.1, 3.2, 3.5, 2.9];
    for (node, angle) in nodes.into_iter().chain([seat]).zip(angles) {
        for i in 0..3 {
            context.set(&mut q, node, 3 + i, e[i] * angle);
        }
    }
    let ModelOptions { t, .. } = ModelOptions::default();
    context.start(t, &q);
    // The start has found the charts of the elements; only nodes are stored anew.
    let changes = context.change_charts(t, &mut q, &mut [], &mut []);
    assert_eq!((changes.charts, changes.residual), (2, false));
    let u = context.unknown(nodes[3], Dof::RZ).unwrap();
    assert!((q[u] - e.z * (3.5 - TAU)).abs() < 1e-14);
    for seed in 0..4 {
        let options = ModelOptions {
            q: q.clone(),
            ..seeded(seed)
        };
        check::model(&mut context, &options).assert();
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
        let section = section.with_mass(1e-6, J).unwrap();
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
    let mut q = vec![0.0; model.pattern().dim()];
    assert!(model.set(&mut q, way, 0, 100.0));
    let report = check::model(&mut model, &ModelOptions { q, ..options });
    assert!(!report.is_ok());
    assert!(report.to_string().contains("runner"), "{report}");
}
