//! Nothing physical may jump when charts change: energy, strains, forces, velocities.

use crate::support::*;

const EXACT: f64 = 1e-12;

/// Reference positions of five nodes: two elements of order two, or four of order one.
const NODES: usize = 5;

fn position(k: usize) -> Vector3<f64> {
    Vector3::new(0.5 * k as f64, 0.0, 0.0)
}

/// What cannot depend on charts.
#[derive(Clone, Debug)]
struct Physical {
    energy: f64,
    states: Vec<SectionState>,
    /// Force and moment at each node in the spatial frame.
    forces: Vec<[Vector3<f64>; 2]>,
}

#[track_caller]
fn same(what: &str, a: &Physical, b: &Physical) {
    let gap = (a.energy - b.energy).abs() / b.energy;
    assert!(gap < EXACT, "{what}: energy {gap:e}");
    assert_eq!(a.states.len(), b.states.len());
    for (x, y) in a.states.iter().zip(&b.states) {
        for (name, x, y) in [
            ("position", x.position, y.position),
            ("Gamma", x.Gamma, y.Gamma),
            ("K", x.K, y.K),
            ("N", x.N, y.N),
            ("M", x.M, y.M),
        ] {
            let gap = (x - y).norm() / y.norm();
            assert!(gap < EXACT, "{what}: {name} {gap:e}");
        }
        assert!((x.frame - y.frame).norm() < EXACT, "{what}: frame");
    }
    for kind in 0..2 {
        let size: f64 = b.forces.iter().map(|f| f[kind].norm()).fold(0.0, f64::max);
        for (k, (x, y)) in a.forces.iter().zip(&b.forces).enumerate() {
            let gap = (x[kind] - y[kind]).norm() / size;
            assert!(gap < EXACT, "{what}: node {k}, kind {kind}: {gap:e}");
        }
    }
}

/// Displacements and rotation vectors: bent, stretched, and turned by θ about e as a whole; `psi` on
/// the branch of θ e.
fn configuration(theta: f64, random: &mut Random) -> Vec<[Vector3<f64>; 2]> {
    let mut e = Vector3::zeros();
    random.direction(1.0, e.as_mut_slice());
    let turn = so3::rotation(&(e * theta));
    (0..NODES)
        .map(|k| {
            let bend: Vector3<f64> = random.vector::<3>() * 0.3;
            let moved = turn * (position(k) + random.vector::<3>() * 0.05);
            let R = turn * so3::rotation(&bend);
            [moved - position(k), so3::log_rotation(&R, &(e * theta))]
        })
        .collect()
}

/// A beam of `NODES` nodes, with inner nodes on a line in the builder's order.
fn model(order: usize) -> (Context, Vec<NodeId>) {
    let mut b = ModelBuilder::new();
    let from = b.node("from", position(0).into()).unwrap();
    let to = b.node("to", position(NODES - 1).into()).unwrap();
    let elements = (NODES - 1) / order;
    let nodes = lay(&mut b, "line", [from, to], elements, order, coupled());
    (Context::new(b.build().unwrap()), nodes)
}

/// The same of elements between two nodes, of which every second follows a parent that stores the complement:
/// no element can do without a change of chart, whatever the angle. Its nodes are the parents.
fn twins() -> (Context, Vec<NodeId>) {
    let mut b = ModelBuilder::new();
    let (mut own, mut ends) = (Vec::new(), Vec::new());
    for k in 0..NODES {
        let at = position(k).into();
        let node = b.node(format!("n{k}"), at).unwrap();
        let twin = b.mapped_node(format!("twin {k}"), at, Twin.boxed(), &[node]);
        own.push(node);
        ends.push(if k % 2 == 0 { node } else { twin.unwrap() });
    }
    for (k, pair) in ends.windows(2).enumerate() {
        let name = format!("beam {k}");
        lay(&mut b, &name, [pair[0], pair[1]], 1, 1, coupled());
    }
    (Context::new(b.build().unwrap()), own)
}

fn coordinates(context: &Context, nodes: &[NodeId], values: &[[Vector3<f64>; 2]]) -> Vec<f64> {
    let mut q = vec![0.0; context.pattern().dim()];
    for (&node, [d, psi]) in nodes.iter().zip(values) {
        for k in 0..3 {
            q[context.unknown(node, Dof::TRANSLATIONS[k]).unwrap()] = d[k];
            q[context.unknown(node, Dof::ROTATIONS[k]).unwrap()] = psi[k];
        }
    }
    q
}

fn at(q: &[f64]) -> Point<'_> {
    Point::statics(0.0, q)
}

fn take(context: &Context, node: NodeId, dofs: [Dof; 3], from: &[f64]) -> Vector3<f64> {
    Vector3::from_fn(|k, _| from[context.unknown(node, dofs[k]).unwrap()])
}

fn physical(context: &mut Context, nodes: &[NodeId], q: &[f64]) -> Physical {
    let mut r = vec![0.0; q.len()];
    context
        .evaluate(at(q), Evaluation::residual(&mut r))
        .unwrap();
    let of_node = |&n: &NodeId| {
        let of = |from: &[f64]| {
            [Dof::TRANSLATIONS, Dof::ROTATIONS]
                .map(|dofs| <[f64; 3]>::from(take(context, n, dofs, from)))
        };
        spatial(&of(q).concat(), &of(&r).concat())
    };
    let forces = nodes.iter().map(of_node).collect();
    Physical {
        energy: context.strain_energy(0.0),
        states: (context.section_states(0.0).into_iter().map(|s| s.1)).collect(),
        forces,
    }
}

/// The same by elements alone, each in the chart in which its largest angle is smallest.
fn by_elements(values: &[[Vector3<f64>; 2]], order: usize) -> Physical {
    let mut out = Physical {
        energy: 0.0,
        states: Vec::new(),
        forces: vec![[Vector3::zeros(); 2]; NODES],
    };
    let frame = frame_along(&Vector3::x(), None);
    for first in (0..NODES - 1).step_by(order) {
        let own = first..=first + order;
        let positions: Vec<Vector3<f64>> = own.clone().map(position).collect();
        let beam = Interpolation::Total
            .beam(&positions, &|_| frame, &coupled())
            .unwrap();
        let largest = |switch: bool| {
            own.clone()
                .map(|k| chart(&values[k][1], switch).norm())
                .fold(0.0, f64::max)
        };
        let switch = largest(true) < largest(false);
        let gap = (largest(true) - largest(false)).abs();
        assert!(gap > 1e-3, "the case does not tell: {gap}");
        let x: Vec<f64> = own
            .clone()
            .flat_map(|k| {
                let [d, psi] = values[k];
                let psi = chart(&psi, switch);
                [d.x, d.y, d.z, psi.x, psi.y, psi.z]
            })
            .collect();
        let motion = moving(&x, &[], &[]);
        let (r, _) = forces(&*beam, &motion).unwrap();
        out.energy += beam.abilities().energy(&motion);
        beam.abilities().section_states(&motion, &mut out.states);
        for (k, (x, r)) in own.zip(x.chunks(6).zip(r.as_slice().chunks(6))) {
            let [force, moment] = spatial(x, r);
            out.forces[k][0] += force;
            out.forces[k][1] += moment;
        }
    }
    out
}

fn chart(psi: &Vector3<f64>, switch: bool) -> Vector3<f64> {
    if switch { so3::complement(psi) } else { *psi }
}

/// Angles of the whole, from well below π to well beyond; nodes bend by up to 0.5 about them.
const ANGLES: [f64; 7] = [2.5, 2.8, 3.0, 3.2, 3.4, 3.7, 4.0];

#[test]
fn changes_of_chart_leave_everything_physical_alone() {
    let mut random = Random::new(21);
    let mut mixed = 0;
    for (name, order) in [("linear", 1), ("quadratic", 2), ("twins", 1)] {
        for theta in ANGLES {
            let what = format!("{name}, {theta} rad");
            let values = configuration(theta, &mut random);
            let expected = by_elements(&values, order);
            let beyond = values.iter().filter(|v| v[1].norm() > PI).count();
            mixed += usize::from(beyond != 0 && beyond != NODES);

            // As given: nodes beyond π go over.
            let (mut m, nodes) = if name == "twins" {
                twins()
            } else {
                model(order)
            };
            let mut q = coordinates(&m, &nodes, &values);
            m.start(0.0, &q);
            let changes = m.change_charts(0.0, &mut q, &mut [], &mut []);
            assert_eq!(changes.charts, beyond, "{what}");
            same(&what, &physical(&mut m, &nodes, &q), &expected);
            // Settled: nothing more to do.
            let before = q.clone();
            let changes = m.change_charts(0.0, &mut q, &mut [], &mut []);
            assert_eq!((changes.charts, changes.residual), (0, false), "{what}");
            assert_eq!(q, before);

            // All in the other chart, and back.
            let complements = values.iter().map(|[d, psi]| [*d, so3::complement(psi)]);
            q = coordinates(&m, &nodes, &complements.collect::<Vec<_>>());
            m.start(0.0, &q);
            let changes = m.change_charts(0.0, &mut q, &mut [], &mut []);
            assert_eq!(changes.charts, NODES - beyond, "{what}");
            same(&what, &physical(&mut m, &nodes, &q), &expected);
            let gap = q.iter().zip(&before).map(|(a, b)| (a - b).abs());
            assert!(gap.fold(0.0, f64::max) < 1e-14, "{what}");
        }
    }
    assert!(
        mixed >= 4,
        "only {mixed} cases have nodes on both sides of π"
    );
}

/// That they are those of the same motion is a law of the check of a model.
#[test]
fn the_chart_changes_as_many_rates_as_there_are() {
    let mut random = Random::new(23);
    for theta in [2.5, 3.2, 4.0] {
        let (mut m, nodes) = model(1);
        let q0 = coordinates(&m, &nodes, &configuration(theta, &mut random));
        let [v0, a0, b0] = [(); 3].map(|()| {
            let mut x = vec![0.0; q0.len()];
            random.fill(&mut x);
            x
        });
        let (mut q, mut v, mut a, mut b) = (q0.clone(), v0.clone(), a0, b0.clone());
        m.change_charts(0.0, &mut q, &mut v, &mut [&mut a, &mut b]);
        // With the second accelerations, velocities alone, or none.
        let (mut q1, mut v1, mut b1) = (q0.clone(), v0.clone(), b0);
        m.change_charts(0.0, &mut q1, &mut v1, &mut [&mut b1]);
        assert_eq!((&q, &v, &b), (&q1, &v1, &b1));
        let (mut q2, mut v2) = (q0.clone(), v0);
        m.change_charts(0.0, &mut q2, &mut v2, &mut []);
        assert_eq!((&q, &v), (&q2, &v2));
        let mut q3 = q0;
        m.change_charts(0.0, &mut q3, &mut [], &mut []);
        assert_eq!(q, q3);
        for &node in &nodes {
            assert!(take(&m, node, Dof::ROTATIONS, &q).norm() <= PI);
        }
    }
}

#[test]
fn partly_held_rotations_change_only_where_the_held_part_is_zero() {
    // In the plane: RX and RY are held at zero, and stay so under the change.
    let build = |held: Box<dyn TimeFunction>| {
        let mut b = ModelBuilder::new();
        let ends = [0, 1].map(|k| b.node(format!("n{k}"), position(k).into()).unwrap());
        lay(&mut b, "beam", ends, 1, 1, coupled());
        b.prescribe(ends[1], Dof::RX, held);
        b.prescribe(ends[1], Dof::RY, Constant(0.0));
        (Context::new(b.build().unwrap()), ends[1])
    };
    let (mut m, node) = build(Box::new(Constant(0.0)));
    let mut q = vec![0.0; m.pattern().dim()];
    let u = m.unknown(node, Dof::RZ).unwrap();
    q[u] = 3.4;
    let mut v = vec![0.0; q.len()];
    v[u] = 0.7;
    let changes = m.change_charts(0.0, &mut q, &mut v, &mut []);
    assert_eq!(changes.charts, 1);
    assert!((q[u] - (3.4 - 2.0 * PI)).abs() < 1e-15);
    assert!(
        (v[u] - 0.7).abs() < 1e-15,
        "about a fixed axis the rate stays"
    );
    // Held elsewhere, now or later.
    let later = Table::ramp(1.0, 2.0, 0.1).unwrap();
    let held: [Box<dyn TimeFunction>; 2] = [Box::new(Constant(0.1)), Box::new(later)];
    for held in held {
        let (mut m, node) = build(held);
        let u = m.unknown(node, Dof::RZ).unwrap();
        q[u] = 3.4;
        let changes = m.change_charts(0.0, &mut q, &mut [], &mut []);
        assert_eq!((changes.charts, q[u]), (0, 3.4));
    }
}

#[test]
fn reactions_are_forces_and_moments_in_space() {
    // A beam stretched and sheared, and turned as a whole: N and N × g in closed form. Beyond π all
    // three nodes are in the other chart; where the two driven ones are, the start has seen to.
    for (angle, changes) in [(0.8, 0), (3.0, 0), (3.5, 1), (5.0, 1)] {
        reactions(angle, changes);
    }
}

fn reactions(angle: f64, changes: usize) {
    let psi = Vector3::new(2.0, -1.0, 2.0) / 3.0 * angle;
    let R = so3::rotation(&psi);
    let Gamma = Vector3::new(0.1, 0.05, -0.02);
    let g = Vector3::x() + Gamma;
    let (mut b, C) = (ModelBuilder::new(), coupled().C);
    let nodes = [0, 1, 2].map(|k| b.node(format!("n{k}"), position(k).into()).unwrap());
    let displaced = |k: usize| R * g * position(k).x - position(k);
    for k in 0..2 {
        let name = format!("beam {k}");
        lay(&mut b, &name, [nodes[k], nodes[k + 1]], 1, 1, coupled());
        for i in 0..3 {
            b.prescribe(nodes[k], Dof::TRANSLATIONS[i], Constant(displaced(k)[i]));
            b.prescribe(nodes[k], Dof::ROTATIONS[i], Constant(psi[i]));
        }
    }
    let mut m = Context::new(b.build().unwrap());
    let mut q = coordinates(&m, &nodes[2..], &[[displaced(2), psi]]);
    m.start(0.0, &q);
    let found = m.change_charts(0.0, &mut q, &mut [], &mut []);
    assert_eq!(found.charts, changes);
    let mut r = [0.0; 6];
    m.evaluate(at(&q), Evaluation::residual(&mut r)).unwrap();
    let reactions = m.reactions();
    assert_eq!(reactions.len(), 2);
    assert_eq!(reactions[0].node, "n0");
    assert_eq!(reactions[0].prescribed, [true; 6]);
    // The support pulls back with −N; the couple of the shear is shared by both ends, and the
    // torque and bending that the coupled section adds are those of the end.
    let N: Vector3<f64> = C.fixed_view::<3, 3>(0, 0) * Gamma;
    let M: Vector3<f64> = C.fixed_view::<3, 3>(3, 0) * Gamma;
    let couple = R * N.cross(&g) * 0.5;
    #[track_caller]
    fn near(found: Vector3<f64>, expected: Vector3<f64>, size: f64) {
        let gap = (found - expected).norm() / size;
        assert!(gap < EXACT, "{gap:e}: {found}{expected}");
    }
    let (force, moment) = (R * N, couple * 0.5 - R * M);
    near(reactions[0].force, -force, force.norm());
    near(reactions[0].moment, moment, moment.norm());
    // Between two equal beams the forces balance, the couples add.
    near(reactions[1].force, Vector3::zeros(), force.norm());
    near(reactions[1].moment, couple, moment.norm());
}
