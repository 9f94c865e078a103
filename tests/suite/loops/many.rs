//! Many loops: what one evaluation asks of a joint does not depend on how many loops there are, and
//! loops that stand on each other.

use super::program::probes;
use crate::support::closures::{GRAVITY, GROUND, PLAIN, arm, body_of, joint, motion};
use crate::support::dynamics::{grounded, revolute};
use crate::support::prelude::*;
use crate::support::program::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A joint that counts how often its pose is asked for.
#[derive(Clone)]
struct Counting(Arc<AtomicUsize>);

impl Joint<1> for Counting {
    fn pose<S: Scalar>(&self, t: S, q: &SVector<S, 1>) -> Pose<S> {
        self.0.fetch_add(1, Ordering::Relaxed);
        Revolute::new([0.0, 0.0, 1.0]).unwrap().pose(t, q)
    }

    fn coordinates(&self) -> [JointCoordinate; 1] {
        [("angle", Quantity::Angle)]
    }
}

/// Parallelograms attached to one another, with a counting joint at the end; how often that is asked in
/// one evaluation with a tangent, and in one change of charts, and how many coordinates each loop has.
fn hung(count: usize) -> [usize; 2] {
    let (mut b, mut root) = grounded();
    let axis = [0.0, 0.0, 1.0];
    for k in 0..count {
        let y = -(k as f64);
        let at = |name: &str| format!("{name} {k}");
        let a = revolute(&mut b, &at("a"), root, axis);
        let end = b.offset(at("crank"), a.frame, [0.0, y - 1.0, 0.0]).unwrap();
        let coupler = revolute(&mut b, &at("b"), end, axis);
        let corner = [1.0, y - 1.0, 0.0];
        let far = b.offset(at("coupler"), coupler.frame, corner).unwrap();
        let foot = b.offset(at("foot"), root, [1.0, y, 0.0]).unwrap();
        let d = revolute(&mut b, &at("d"), foot, axis);
        let tip = b.offset(at("rocker"), d.frame, corner).unwrap();
        let c = revolute(&mut b, &at("c"), far, axis);
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
    let mut context = Context::new(b.build().unwrap());
    let mobility = context.mobility();
    assert_eq!(mobility.freedoms, count + 1);
    // Four coordinates and six equations for each loop: none is solved together with another.
    let sizes = [mobility.loops, mobility.equations, mobility.coordinates];
    assert_eq!(sizes, [count, 6 * count, 4 * count + 1]);
    assert_eq!(context.descriptions().len(), count);
    let n = context.pattern().dim();
    assert_eq!(context.pattern().len(), n * n);
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
    context.evaluate(at, out).unwrap();
    let evaluation = calls.swap(0, Ordering::Relaxed);
    context.change_charts(0.0, &mut q, &mut v, &mut [&mut a]);
    [evaluation, calls.load(Ordering::Relaxed)]
}

#[test]
fn a_joint_is_asked_as_often_in_many_loops_as_in_few() {
    let few = hung(2);
    assert!(few[0] > 0);
    assert_eq!(hung(12), few);
}

/// A boom that carries an arm and a strut to it (a loop on the moving boom), while a tie leads from the
/// arm to the ground (a loop through the joint of the boom). The joint of the boom stands on the ground, or
/// on a post there.
fn boom(base: &str, closure: &str) -> String {
    let inertia = "center = [0.5, 0.1, 0.2]\ninertia = [0.1, 0.2, 0.3]";
    let [arm_tip, foot] =
        ["arm tip", "foot"].map(|child| format!("child = \"{child}\"\n{closure}"));
    [
        GROUND,
        &arm("post", "ground", [0.0, 0.0, 0.0]),
        &joint("A", "revolute", base, "axis = [0, 1, 0]"),
        &arm("boom tip", "A", [1.0, 0.0, 1.0]),
        &joint("B", "revolute", "boom tip", "axis = [0, 1, 0.3]"),
        &arm("arm tip", "B", [2.0, 0.0, 0.5]),
        &arm("boom middle", "A", [0.5, 0.0, 0.0]),
        &joint("S", "spherical", "boom middle", ""),
        &arm("strut tip", "S", [2.0, 0.0, 0.5]),
        &joint("end", "spherical", "strut tip", &arm_tip),
        &arm("arm middle", "B", [1.5, 0.2, 1.0]),
        &joint("D", "spherical", "arm middle", ""),
        &arm("tie tip", "D", [2.0, 0.0, -1.0]),
        &arm("foot", "ground", [2.0, 0.0, -1.0]),
        &joint("last", "spherical", "tie tip", &foot),
        &["A", "B", "S", "D"]
            .map(|node| body_of(node, 1.0, inertia))
            .concat(),
        &HOLDING.map(probes).concat(),
        &probes("ground"),
        GRAVITY,
        &motion(0.02, 0.01),
        PLAIN,
    ]
    .concat()
}

/// Frames whose joints are compared.
const HOLDING: [&str; 5] = ["post", "A", "B", "S", "D"];

#[test]
fn a_loop_may_stand_on_a_frame_that_another_loop_moves() {
    // Multipliers read no root: forces at the start are the same to rounding.
    for base in ["ground", "post"] {
        let [by_map, other] = ["", "closure = \"multipliers\""]
            .map(|closure| recorded(&format!("boom_{base}"), &boom(base, closure)).remove(0));
        for of in HOLDING.iter().chain(&["ground"]) {
            for axis in ["x", "y", "z"] {
                for what in ["force", "moment"] {
                    let column = format!("{what} {of}.{axis}");
                    let [found, exact] = [&other, &by_map].map(|row| number(row, &column));
                    assert_close(found, exact, 1e-8, format_args!("{base}, {column}"));
                }
            }
        }
    }
}
