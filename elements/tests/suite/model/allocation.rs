//! An evaluation allocates nothing: buffers are made when the model is, and are no larger than it needs.

use crate::support::polynomial_spring::PolynomialSpring;
use crate::support::strain_beam::{Reissner, strain_beam};
use crate::support::*;
use allocation_counter::measure;

#[test]
fn nothing_is_allocated_after_the_first_evaluation() {
    let mut b = ModelBuilder::new();
    let root = b.node("root", [0.0; 3]).unwrap();
    let end = b.node("end", [3.0, 0.0, 0.0]).unwrap();
    let nodes = lay(&mut b, "line", [root, end], 3, 2, coupled());
    // The other interpolation, between the same nodes.
    let section = coupled().with_mass(2.0, Matrix3::identity()).unwrap();
    let positions = [nodes[0], nodes[1], nodes[2]].map(|n| b.position(n));
    let frame = frame_along(&(positions[1] - positions[0]), None);
    for section in [section, section.with_damping(DAMPING).unwrap()] {
        for count in [2, 3] {
            let beam = Interpolation::Geodesic.beam(&positions[..count], &|_| frame, &section);
            let name = format!("geodesic {count} {}", section.damping.mass);
            b.element(name, beam.unwrap(), &nodes[..count]).unwrap();
        }
    }
    let offset = GrowingOffset([0.0, 0.3, 0.4]).boxed();
    let dependent = b
        .mapped_node("dependent", [3.0, 0.3, 0.4], offset, &[end])
        .unwrap();
    let load = NodalLoad::new(LoadKind::FollowerMoment, [1.0, 2.0, 3.0], Proportional(1.0));
    b.element("load", load, &[dependent]).unwrap();
    let body = RigidBody::new(2.0, Matrix3::identity(), Vector3::x()).unwrap();
    let weight = body.weight([0.0, 0.0, -9.81], Proportional(1.0));
    b.element("body", body, &[dependent]).unwrap();
    b.element("weight", weight, &[dependent]).unwrap();
    let ends = [b.position(nodes[1]), b.position(dependent)];
    let spring = AxialSpring::new(&ends, 3.0, 1.0).unwrap();
    b.element("spring", spring, &[nodes[1], dependent]).unwrap();
    let (axes, one) = (Matrix3::identity(), Matrix6::identity());
    let bushing = Bushing::new(&ends, &axes, &one, &one).unwrap();
    b.element("bushing", bushing, &[nodes[1], dependent])
        .unwrap();
    let ramp = Table::ramp(0.0, 1.0, 2.0).unwrap();
    let wind = LineLoad::new(&positions, [0.0, 1.0, 0.0], true, ramp).unwrap();
    let turning = LineLoad::new(&positions, [0.0, 1.0, 0.0], true, Proportional(1.0));
    let turning = turning.unwrap().with_interpolation(Interpolation::Geodesic);
    b.element("wind", wind, &nodes[..3]).unwrap();
    b.element("geodesic wind", turning, &nodes[..3]).unwrap();
    let by_energy = PolynomialSpring {
        positions: ends,
        rest_length: 1.0,
        k: [3.0, 0.5, -0.2],
        c: 0.2,
    };
    b.element("energy", by_energy.into_element(), &[nodes[1], dependent])
        .unwrap();
    let frame = frame_along(&(ends[1] - ends[0]), None);
    let beam = strain_beam(Reissner, &ends, &frame, &section).unwrap();
    b.element("beam", beam, &[nodes[1], dependent]).unwrap();
    b.support(root, &[Dof::X, Dof::Y]);
    for dof in Dof::ROTATIONS {
        b.prescribe(root, dof, Constant(1.0));
    }
    let mut context = Context::new(b.build().unwrap());
    let n = context.pattern().dim();
    let mut q = vec![0.0; n];
    // Nodes astride π, so that elements change charts.
    for (k, &node) in nodes.iter().enumerate().skip(1) {
        let psi = Vector3::new(1.0, 1.0, 1.0) * (1.7 + 0.05 * k as f64);
        for (i, dof) in Dof::ROTATIONS.into_iter().enumerate() {
            q[context.unknown(node, dof).unwrap()] = psi[i];
        }
    }
    let changes = context.change_charts(0.5, &mut q, &mut [], &mut []);
    assert!(changes.charts > 0 && changes.charts < nodes.len() - 1);
    let (v, a) = (vec![0.3; n], vec![-0.2; n]);
    let (mut r, mut r_t) = (vec![0.0; n], vec![0.0; n]);
    let mut S = vec![0.0; context.pattern().len()];
    let mut all = |context: &mut dyn System| {
        let rest = Point::statics(0.5, &q);
        let moving = point(0.5, [&q, &v, &a]);
        for (at, weights) in [(rest, Weights::STATIC), (moving, weights(1.0, 2.0, 3.0))] {
            let out = Evaluation {
                r_t: Some(&mut r_t),
                ..Evaluation::with_tangent(&mut r, weights, &mut S)
            };
            context.evaluate(at, out).unwrap();
            context.evaluate(at, Evaluation::residual(&mut r)).unwrap();
            let out = Evaluation {
                previous: Some(rest),
                ..Evaluation::with_tangent(&mut r, weights, &mut S)
            };
            context.evaluate(at, out).unwrap();
        }
    };
    all(&mut context);
    assert_eq!(measure(|| all(&mut context)).count_total, 0);
    let counted = measure(|| drop(std::hint::black_box(vec![0_u8; 64])));
    assert_eq!(counted.count_total, 1, "the counter counts");
}

/// Bytes that the context of a chain of bars keeps.
fn kept(count: usize) -> f64 {
    let mut b = ModelBuilder::new();
    let mut end = b.node("ground", [0.0; 3]).unwrap();
    b.support(end, &Dof::ALL);
    for k in 0..count {
        let axis = Revolute::new([0.0, 0.0, 1.0]).unwrap();
        let pin = b.attach(&format!("pin {k}"), end, axis).unwrap();
        let body = RigidBody::new(1.0, Matrix3::identity(), Vector3::x()).unwrap();
        b.element(format!("bar {k}"), body, &[pin.frame]).unwrap();
        let position = [k as f64 + 1.0, 0.0, 0.0];
        end = b.offset(format!("end {k}"), pin.frame, position).unwrap();
    }
    let model = b.build().unwrap();
    let mut context = None;
    let bytes = measure(|| context = Some(Context::new(model))).bytes_max;
    assert_eq!(context.unwrap().pattern().len(), count * count);
    bytes as f64
}

/// The memory of a chain is quadratic in its length, like its mass matrix; tangents of every body for
/// every pair of coordinates before it would be cubic.
#[test]
fn chains_grow_with_the_square_of_their_length() {
    let sizes = [20, 40, 80, 160].map(|count| (count as f64, kept(count)));
    let slope = |k: usize| (sizes[k + 1].1 - sizes[k].1) / (sizes[k + 1].0 - sizes[k].0);
    // The factor of the square through three sizes; the same through all of them if there is no cube.
    let square = |k: usize| (slope(k + 1) - slope(k)) / (sizes[k + 2].0 - sizes[k].0);
    let growth = square(1) / square(0);
    assert!((0.95..1.05).contains(&growth), "{growth}: {sizes:?}");
}
