//! Charts of nodes and elements: in which an element is evaluated, and what a change of them leaves alone.

use crate::support::*;

const EXACT: f64 = 1e-12;

fn position(k: usize) -> Vector3<f64> {
    Vector3::new(0.5 * k as f64, 0.0, 0.0)
}

fn at(q: &[f64]) -> Point<'_> {
    Point::statics(0.0, q)
}

fn coordinates(context: &Context, nodes: &[NodeId], values: &[[Vector3<f64>; 2]]) -> Vec<f64> {
    let mut q = vec![0.0; context.pattern().dim()];
    for (&node, [d, psi]) in nodes.iter().zip(values) {
        for k in 0..3 {
            context.set(&mut q, node, k, d[k]);
            context.set(&mut q, node, 3 + k, psi[k]);
        }
    }
    q
}

/// Between rotations about several axes the interpolated one depends on the chart, and with it strains and
/// energy: by the square of the angle between the nodes, 0.1.
#[test]
fn elements_are_evaluated_in_the_chart_with_the_smallest_largest_angle() {
    let cases: [&[f64]; 4] = [&[2.9, 3.2], &[3.4, 2.9], &[3.0, 3.1, 3.2], &[2.8, 3.3, 3.1]];
    for (angles, stored) in cases.iter().flat_map(|c| [(c, false), (c, true)]) {
        let count = angles.len();
        let mut b = ModelBuilder::new();
        let ends = [0, count - 1].map(|k| b.node(format!("{k}"), position(k).into()).unwrap());
        let nodes = lay(&mut b, "beam", ends, 1, count - 1, coupled());
        let mut m = Context::new(b.build().unwrap());
        let psi = |k: usize, other: bool| {
            let psi = Vector3::new(0.0, 0.1 * k as f64, 1.0).normalize() * angles[k];
            if other { so3::complement(&psi) } else { psi }
        };
        let of = |other: bool| {
            let nodes = (0..count).map(|k| [Vector3::zeros(), psi(k, other)]);
            nodes.collect::<Vec<_>>()
        };
        let q = coordinates(&m, &nodes, &of(stored));
        m.start(0.0, &q);
        m.configure(at(&q)).unwrap();
        let positions: Vec<_> = (0..count).map(position).collect();
        let frame = frame_along(&Vector3::x(), None);
        let beam = Interpolation::Total.beam(&positions, &|_| frame, &coupled());
        let beam = beam.unwrap();
        let [here, there] = [false, true].map(|other| {
            let x: Vec<f64> = (of(other).into_iter().flatten())
                .flat_map(<[f64; 3]>::from)
                .collect();
            let largest = (0..count).map(|k| psi(k, other).norm()).fold(0.0, f64::max);
            (largest, beam.abilities().energy(&moving(&x, &[], &[])))
        });
        let [best, other] = match here.0 < there.0 {
            true => [here, there],
            false => [there, here],
        };
        let gap = (m.strain_energy(0.0) / best.1 - 1.0).abs();
        assert!(gap < EXACT, "{angles:?}: {gap:e}");
        assert!((other.1 / best.1 - 1.0).abs() > 1e-6, "{angles:?}");
    }
}

#[test]
fn forces_of_an_accepted_state_do_not_depend_on_the_charts_to_come() {
    // Between rotations about two axes the interpolated one depends on the chart, and with it strains
    // and energy: by the square of the angle between the nodes, 0.1.
    let mut b = ModelBuilder::new();
    let ends = [0.0, 0.5].map(|x| b.node(format!("{x}"), [x, 0.0, 0.0]).unwrap());
    lay(&mut b, "beam", ends, 1, 1, coupled());
    let mut m = Context::new(b.build().unwrap());
    let turned = |angle: f64| {
        let psi = |k: f64| Vector3::new(0.0, 0.1 * k, 1.0).normalize() * angle;
        coordinates(&m, &ends, &[0.0, 1.0].map(|k| [Vector3::zeros(), psi(k)]))
    };
    let (mut before, mut now) = (turned(3.0), turned(3.3));
    m.start(0.0, &before);
    let changes = m.change_charts(0.0, &mut before, &mut [], &mut []);
    assert_eq!(changes.charts, 0);
    let mut r = [0.0; 12];
    m.evaluate(at(&now), Evaluation::residual(&mut r)).unwrap();
    let stored = m.energies_and_momentum(at(&now)).unwrap().energies.stored;
    let sections = m.section_states(0.0);
    let changes = m.change_charts(0.0, &mut now, &mut [], &mut []);
    assert_eq!((changes.charts, changes.residual), (2, true));
    let told = m.energies_and_momentum(at(&now)).unwrap().energies.stored;
    assert!((told / stored - 1.0).abs() < 1e-12, "{told}, not {stored}");
    for ((_, a), (_, b)) in m.section_states(0.0).iter().zip(&sections) {
        let gap = (a.N - b.N).norm() / b.N.norm() + (a.M - b.M).norm() / b.M.norm();
        assert!(gap < 1e-12, "{gap:e}");
    }
    // The next step begins in the other chart.
    m.evaluate(at(&now), Evaluation::residual(&mut r)).unwrap();
    let other = m.energies_and_momentum(at(&now)).unwrap().energies.stored;
    assert!((other / stored - 1.0).abs() > 1e-6, "{other}, {stored}");
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
    // About a fixed axis the rate stays.
    assert!((v[u] - 0.7).abs() < 1e-15);
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
    let reactions = m.forces(at(&q)).unwrap().reactions();
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
