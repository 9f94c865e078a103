//! Many loops: what one evaluation asks of a joint does not depend on how many loops there are.

#![allow(non_snake_case, clippy::unwrap_used)]

use nalgebra::{Matrix3, SVector, Vector3};
use pullback::elements::body::RigidBody;
use pullback::elements::joint::{Joint, Pose, Released, Revolute, offset, revolute};
use pullback::elements::model::{Dof, ModelBuilder};
use pullback::manifold::scalar::Scalar;
use pullback::manifold::system::{Evaluation, Point, System, Weights};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A joint that counts how often its pose is asked for.
#[derive(Clone)]
struct Counting(Arc<AtomicUsize>);

impl Joint<7> for Counting {
    fn pose<S: Scalar>(&self, t: S, q: &SVector<S, 7>) -> Pose<S> {
        self.0.fetch_add(1, Ordering::Relaxed);
        Revolute::new([0.0, 0.0, 1.0]).unwrap().pose(t, q)
    }

    fn released(&self) -> &'static [Released] {
        const { &[Released::angle("angle")] }
    }
}

/// Parallelograms hung on one another, with a counting joint at the end; how often that is asked in
/// one evaluation with a tangent, and in one change of charts, and how many coordinates each loop has.
fn hung(count: usize) -> [usize; 2] {
    let mut b = ModelBuilder::new();
    let axis = [0.0, 0.0, 1.0];
    let mut root = b.node("ground", [0.0; 3]).unwrap();
    b.support(root, &Dof::ALL);
    for k in 0..count {
        let y = -(k as f64);
        let at = |name: &str| format!("{name} {k}");
        let a = revolute(&mut b, &at("a"), root, axis).unwrap();
        let end = offset(&mut b, &at("crank"), a.frame, [0.0, y - 1.0, 0.0]).unwrap();
        let coupler = revolute(&mut b, &at("b"), end, axis).unwrap();
        let far = offset(&mut b, &at("coupler"), coupler.frame, [1.0, y - 1.0, 0.0]).unwrap();
        let foot = offset(&mut b, &at("foot"), root, [1.0, y, 0.0]).unwrap();
        let d = revolute(&mut b, &at("d"), foot, axis).unwrap();
        let tip = offset(&mut b, &at("rocker"), d.frame, [1.0, y - 1.0, 0.0]).unwrap();
        let c = revolute(&mut b, &at("c"), far, axis).unwrap();
        b.close(c.frame, tip).unwrap();
        for frame in [a.frame, coupler.frame, d.frame] {
            let body = RigidBody::new(1.0, Matrix3::identity(), Vector3::zeros()).unwrap();
            b.element(format!("body {frame:?}"), body, &[frame])
                .unwrap();
        }
        root = coupler.frame;
    }
    let calls = Arc::new(AtomicUsize::new(0));
    let last = b.attach("last", root, Counting(calls.clone())).unwrap();
    let body = RigidBody::new(1.0, Matrix3::identity(), Vector3::x()).unwrap();
    b.element("last", body, &[last.frame]).unwrap();
    let mut model = b.build().unwrap();
    let mobility = model.mobility();
    assert_eq!(mobility.freedoms, count + 1);
    // Four coordinates and six equations for each loop: none is solved together with another.
    let sizes = [mobility.loops, mobility.equations, mobility.coordinates];
    assert_eq!(sizes, [count, 6 * count, 4 * count + 1]);
    assert_eq!(model.notes().len(), count);
    let n = model.pattern().dim();
    assert_eq!(model.pattern().len(), n * n);
    let mut S = vec![0.0; n * n];
    let (mut q, mut v, mut a, mut r) = (vec![0.0; n], vec![0.3; n], vec![0.1; n], vec![0.0; n]);
    calls.store(0, Ordering::Relaxed);
    let weights = Weights {
        K: 1.0,
        C: 2.0,
        M: 3.0,
    };
    let out = Evaluation::with_tangent(&mut r, weights, &mut S);
    let at = Point {
        t: 0.0,
        q: &q,
        v: &v,
        a: &a,
    };
    model.evaluate(at, out).unwrap();
    let evaluation = calls.swap(0, Ordering::Relaxed);
    model.change_charts(0.0, &mut q, &mut v, &mut [&mut a]);
    [evaluation, calls.load(Ordering::Relaxed)]
}

#[test]
fn a_joint_is_asked_as_often_in_many_loops_as_in_few() {
    let few = hung(2);
    assert!(few[0] > 0 && few[1] > 0);
    assert_eq!(hung(12), few);
}
