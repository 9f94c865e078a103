//! An evaluation allocates nothing: buffers are made when the model is, and are no larger than it needs.

use crate::support::everything::everything;
use crate::support::*;
use allocation_counter::measure;

#[test]
fn nothing_is_allocated_after_the_first_evaluation() {
    let mut context = everything();
    let mut q = vec![0.0; context.pattern().dim()];
    // Nodes astride π, so that elements change charts.
    let nodes = ["arm/1", "arm/2", "arm/3", "corner", "leg/1", "tip"];
    for (k, name) in nodes.iter().enumerate() {
        let node = context.find(name).unwrap();
        let psi = Vector3::new(1.0, 1.0, 1.0) * (1.7 + 0.05 * k as f64);
        for i in 0..3 {
            context.set(&mut q, node, 3 + i, psi[i]);
        }
    }
    let changes = context.change_charts(0.5, &mut q, &mut [], &mut []);
    assert!(changes.charts > 0 && changes.charts < nodes.len());
    let n = q.len();
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
