//! The assembled model as a system: its tangent is that of its residual, in whatever charts.

use crate::support::*;

/// States of a model's n unknowns near a configuration.
fn around(context: &Context, q: &DVector<f64>, spread: f64) -> Vec<(String, TestState)> {
    let n = context.pattern().dim();
    let mut random = Random::new(5);
    let mut out = Vec::new();
    for k in 0..2 {
        let mut moved = q.clone();
        moved
            .iter_mut()
            .for_each(|x| *x += random.range(-spread, spread));
        out.push((
            format!("{k}, at rest"),
            TestState::statics(0.6, moved.clone()),
        ));
        let (mut v, mut a) = (DVector::zeros(n), DVector::zeros(n));
        random.fill(v.as_mut_slice());
        random.fill(a.as_mut_slice());
        let (t, x) = (0.6, moved);
        out.push((format!("{k}, moving"), TestState { t, x, v, a }));
    }
    out
}

fn check_around(what: &str, context: &mut Context, q: &DVector<f64>, spread: f64) {
    let states = around(context, q, spread);
    check::system(what, context, &states).assert();
}

/// A configuration with these rotation vectors of nodes.
fn turned(
    context: &Context,
    nodes: &[NodeId],
    psi: impl Fn(usize) -> Vector3<f64>,
) -> DVector<f64> {
    let mut q = DVector::zeros(context.pattern().dim());
    for (k, &node) in nodes.iter().enumerate() {
        for (i, dof) in Dof::ROTATIONS.into_iter().enumerate() {
            if let Some(u) = context.unknown(node, dof) {
                q[u] = psi(k)[i];
            }
        }
    }
    q
}

#[test]
fn partly_prescribed_and_driven_coordinates() {
    let mut b = ModelBuilder::new();
    let [root, corner, tip] = frame_model(&mut b, None);
    b.support(root, &[Dof::X, Dof::Z, Dof::RY]);
    b.prescribe(corner, Dof::Y, sine(0.3));
    b.prescribe(corner, Dof::RX, sine(0.8));
    for dof in Dof::ROTATIONS {
        b.prescribe(tip, dof, sine(0.5));
    }
    let mut context = Context::new(b.build().unwrap());
    let n = context.pattern().dim();
    assert_eq!(n, 7 * 6 - 8);
    assert!(!context.is_symmetric());
    check_around("driven frame", &mut context, &DVector::zeros(n), 0.4);
}

#[test]
fn a_rotation_driven_past_a_turn() {
    // About an axis that wanders, so that taking off a turn changes the rates too; at t = 0.6 the
    // tip has turned by 7.1 rad.
    let mut b = ModelBuilder::new();
    let [root, _, tip] = frame_model(&mut b, None);
    b.support(root, &Dof::ALL);
    b.prescribe(tip, Dof::RX, Proportional(8.0));
    b.prescribe(tip, Dof::RY, sine(3.0));
    b.prescribe(tip, Dof::RZ, Proportional(7.0));
    let psi = |t: f64| Vector3::new(8.0 * t, sine(3.0).at(t, &[])[0], 7.0 * t);
    let mut context = Context::new(b.build().unwrap());
    let n = context.pattern().dim();
    let mut q = DVector::zeros(n);
    context.start(0.6, q.as_slice());
    let changes = context.change_charts(0.6, q.as_mut_slice(), &mut [], &mut []);
    assert_eq!(changes.charts, 0, "the start has done it");
    check_around("driven past a turn", &mut context, &q, 0.2);
    // The last of these states is at t = 0.6.
    let found = context.node_state(tip);
    let expected = nalgebra::Rotation3::new(psi(0.6));
    assert!((found.R - expected.matrix()).norm() < 1e-13);
    assert!((found.psi.norm() - (psi(0.6).norm() - 2.0 * PI)).abs() < 1e-14);
    // Back: 4.2 rad is nearer to one turn than to none, 2.2 rad is not. And forth.
    for (t, charts) in [(0.3, 0), (0.1, 1), (0.3, 1)] {
        let changes = context.change_charts(t, q.as_mut_slice(), &mut [], &mut []);
        assert_eq!(changes.charts, charts, "{} rad", psi(t).norm());
    }
}

#[test]
fn nodes_that_follow_through_maps() {
    // The leg is attached to the corner by an offset that grows with time; the tip follows two parents.
    let mut b = ModelBuilder::new();
    let root = b.node("root", [0.0; 3]).unwrap();
    let corner = b.node("corner", [1.0, 0.0, 0.0]).unwrap();
    let angle = b.coordinates("angle", &[Quantity::Angle]).unwrap();
    let offset = GrowingOffset([0.0, 0.3, 0.4]).boxed();
    let dependent = b
        .mapped_node("dependent", [1.0, 0.3, 0.4], offset, &[corner])
        .unwrap();
    let tip = b.node("tip", [1.0, 1.0, 1.0]).unwrap();
    let pin = b
        .mapped_node("pin", [0.0, 0.0, 1.0], TwoTurn.boxed(), &[tip, angle])
        .unwrap();
    let far = b.node("far", [-1.0, 0.5, 1.0]).unwrap();
    for (name, ends) in [
        ("arm", [root, corner]),
        ("leg", [dependent, tip]),
        ("hand", [pin, far]),
        // Slave and parent in one element: their blocks meet.
        ("brace", [corner, dependent]),
    ] {
        lay(&mut b, name, ends, 1, 1, section());
    }
    // Residuals that depend on velocities and accelerations, symmetric in nothing.
    b.element("coupling", Coupling, &[dependent, pin]).unwrap();
    b.element("coupling 2", Coupling, &[corner, tip]).unwrap();
    let load = NodalLoad::new(LoadKind::FollowerForce, [1.0, -2.0, 0.5], sine(1.0));
    b.element("load", load, &[dependent]).unwrap();
    b.support(root, &Dof::ALL);
    b.prescribe(corner, Dof::RZ, sine(0.4));
    b.prescribe(corner, Dof::X, sine(0.2));
    let mut context = Context::new(b.build().unwrap());
    let n = context.pattern().dim();
    assert_eq!(n, 4 + 1 + 6 + 6);
    check_around("joints", &mut context, &DVector::zeros(n), 0.4);
}

/// A chain of `count` beams with couplings in velocities and accelerations; clamped at the start.
fn chain(count: usize) -> (Context, Vec<NodeId>) {
    let mut b = ModelBuilder::new();
    let from = b.node("0", [0.0; 3]).unwrap();
    let to = b.node("end", [count as f64, 0.0, 0.0]).unwrap();
    let nodes = lay(&mut b, "chain", [from, to], count, 1, coupled());
    for pair in nodes.windows(2) {
        b.element("coupling", Coupling, pair).unwrap();
    }
    let positions = [b.position(nodes[0]), b.position(nodes[1])];
    let wind = LineLoad::new(&positions, [0.0, 2.0, 1.0], true, sine(2.0)).unwrap();
    b.element("wind", wind, &nodes[..2]).unwrap();
    (Context::new(b.build().unwrap()), nodes)
}

#[test]
fn nodes_astride_pi() {
    let (mut context, nodes) = chain(3);
    let e = Vector3::new(0.36, 0.48, -0.8);
    // 2.7, 3.1, 3.3, 3.5 rad: the last two are stored as their complements.
    let angles = [2.7, 3.1, 3.3, 3.5];
    let mut q = turned(&context, &nodes, |k| e * angles[k]);
    context.start(0.6, q.as_slice());
    let changes = context.change_charts(0.6, q.as_mut_slice(), &mut [], &mut []);
    // The start has found the charts of the elements; only nodes are stored anew.
    assert_eq!((changes.charts, changes.residual), (2, false));
    // Small disturbances: the charts of nodes and elements stay, as they do within a step.
    check_around("astride pi", &mut context, &q, 0.05);
    let u = context.unknown(nodes[3], Dof::RZ).unwrap();
    assert!((q[u] - e.z * (3.5 - 2.0 * PI)).abs() < 1e-14);
}

#[test]
fn mapped_nodes_stored_in_the_other_chart() {
    // Twin stores the complement of its parent's rotation: elements must change charts of nodes
    // that have no coordinates of their own, and pull back twice.
    let mut b = ModelBuilder::new();
    let positions = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.5, 0.0]];
    let parents = [0, 1, 2].map(|k| b.node(format!("m{k}"), positions[k]).unwrap());
    let twin = b
        .mapped_node("twin", positions[1], Twin.boxed(), &parents[1..2])
        .unwrap();
    for (name, ends) in [("a", [parents[0], twin]), ("b", [twin, parents[2]])] {
        lay(&mut b, name, ends, 1, 1, coupled());
        b.element(format!("coupling {name}"), Coupling, &ends)
            .unwrap();
    }
    b.prescribe(parents[1], Dof::RY, sine(0.3));
    let mut context = Context::new(b.build().unwrap());
    let mut q = turned(&context, &parents, |k| {
        Vector3::new(2.0 + 0.2 * k as f64, 0.5, -1.0)
    });
    context.start(0.6, q.as_slice());
    let changes = context.change_charts(0.6, q.as_mut_slice(), &mut [], &mut []);
    assert_eq!(changes.charts, 0);
    check_around("twin", &mut context, &q, 0.1);
}

#[test]
fn a_tangent_from_the_previous_iterate_differs_by_the_square_of_the_step() {
    let (mut context, nodes) = chain(2);
    let e = Vector3::new(0.36, 0.48, -0.8);
    let mut q = turned(&context, &nodes, |k| e * [2.9, 3.1, 3.3][k]);
    context.start(0.6, q.as_slice());
    context.change_charts(0.6, q.as_mut_slice(), &mut [], &mut []);
    let mut random = Random::new(2);
    let n = q.len();
    let mut d = DVector::zeros(n);
    random.direction(1.0, d.as_mut_slice());
    random.fill(q.as_mut_slice());
    let mut tangent = |previous: Option<&DVector<f64>>| {
        let at = |q| Point::statics(0.6, q);
        let (mut r, mut S) = (vec![0.0; n], vec![0.0; context.pattern().len()]);
        let out = Evaluation::with_tangent(&mut r, Weights::STATIC, &mut S);
        match previous {
            None => context.evaluate(at(q.as_slice()), out),
            Some(from) => {
                let previous = Some(at(from.as_slice()));
                context.evaluate(at(q.as_slice()), Evaluation { previous, ..out })
            }
        }
        .unwrap();
        (r, context.pattern().matrix(&S))
    };
    let (r, K) = tangent(None);
    let mut report = check::Report::new("previous iterate");
    report.slope("K", "chain", 2.0, 0.05, K.norm(), |step| {
        let (same, from) = tangent(Some(&(&q - &d * step)));
        assert_eq!(same, r);
        (from - &K).norm()
    });
    report.assert();
    let (_, K_again) = tangent(None);
    assert_eq!(K, K_again, "the previous iterate is forgotten");
}
