//! Supports, numbering, names, axes and lines of a model.

use crate::support::*;
use nalgebra::Unit;
use std::time::Instant;

fn built(support: impl Fn(&mut ModelBuilder, [NodeId; 2])) -> Context {
    let (mut b, ends) = simple();
    support(&mut b, ends);
    Context::new(b.build().unwrap())
}

#[test]
fn structures_that_can_move_as_rigid_bodies() {
    let motion = |context: Context| {
        let (node, motion) = context.free_motion().expect("a motion");
        assert_eq!(context.node(node).name(), "a");
        motion
    };
    let clamped = built(|b, n| b.support(n[0], &Dof::ALL));
    assert_eq!(clamped.free_motion(), None);
    let slides = built(|b, n| b.support(n[0], &[Dof::Y, Dof::Z, Dof::RX, Dof::RY, Dof::RZ]));
    assert_eq!(motion(slides), "translation along (1.000, 0.000, 0.000)");
    // Both ends pinned: it can spin about its axis, which passes through the middle.
    let spins = built(|b, n| n.iter().for_each(|&n| b.support(n, &Dof::TRANSLATIONS)));
    let axis = "rotation about the direction (1.000, 0.000, 0.000) through (0.500, 0.000, 0.000)";
    assert_eq!(motion(spins), axis);
    // A hinge at b about e3: the axis passes through b, not through the centre.
    let swings = built(|b, n| {
        b.support(n[1], &[Dof::X, Dof::Y, Dof::Z, Dof::RX, Dof::RY]);
    });
    let axis = "rotation about the direction (0.000, 0.000, 1.000) through (1.000, 0.000, 0.000)";
    assert_eq!(motion(swings), axis);
    assert!(motion(built(|_, _| ())).starts_with("translation"));
    // Every part by itself; a joint connects, a load does not.
    let (mut b, ends) = simple();
    b.support(ends[0], &Dof::ALL);
    let second = [[0.0, 3.0, 0.0], [1.0, 3.0, 0.0]].map(|p| b.node(format!("{p:?}"), p).unwrap());
    beam(&mut b, "second", second);
    let model = b.build().unwrap();
    let (node, _) = model.free_motion().unwrap();
    assert_eq!(model.node(node).name(), "[0.0, 3.0, 0.0]");
    let (mut b, ends) = simple();
    b.support(ends[0], &Dof::ALL);
    let offset = GrowingOffset([0.0, 1.0, 0.0]).boxed();
    let dependent = b
        .mapped_node("dependent", [1.0, 1.0, 0.0], offset, &ends[1..])
        .unwrap();
    let far = b.node("far", [1.0, 2.0, 0.0]).unwrap();
    beam(&mut b, "second", [dependent, far]);
    assert_eq!(b.build().unwrap().free_motion(), None);
}

#[test]
fn unknowns_have_numbers_names_and_kinds() {
    let (mut b, ends) = simple();
    let hinge = b
        .coordinates("hinge", &[Quantity::Angle, Quantity::Other])
        .unwrap();
    // Six coordinates that a joint releases are no frame: their charts are never changed.
    let six = b.coordinates("six", &[Quantity::Other; 6]).unwrap();
    b.element("idle", Idle(14), &[ends[1], hinge, six]).unwrap();
    b.support(ends[0], &[Dof::X, Dof::RX]);
    let mut context = Context::new(b.build().unwrap());
    assert_eq!(context.pattern().dim(), 4 + 6 + 2 + 6);
    assert_eq!(context.unknown(ends[0], Dof::X), None);
    assert_eq!(context.unknown(ends[0], Dof::Y), Some(0));
    assert_eq!(context.unknown(ends[1], Dof::RZ), Some(9));
    assert_eq!(context.unknown(ends[0], Dof::RX), None);
    assert!(context.unknown(ends[0], Dof::RY).is_some());
    assert_eq!(context.name(0), "node a, displacement along e2");
    assert_eq!(context.name(9), "node b, rotation about e3");
    assert_eq!(context.name(11), "hinge, coordinate 2");
    assert_eq!(context.name(12), "six, coordinate 1");
    let kinds = [0, 2, 9, 10, 11, 12].map(|i| context.pattern().coordinates()[i].quantity);
    use Quantity::{Angle, Length, Other};
    assert_eq!(kinds, [Length, Angle, Angle, Angle, Other, Other]);
    assert_eq!(context.frames().count(), 2);
    assert_eq!(context.find("hinge"), Some(hinge));
    assert_eq!(context.find("none"), None);
    assert_eq!(context.length(), 1.0);
    assert_eq!(context.elements().len(), 2);
    let mut q = vec![0.0; 18];
    q[12..].fill(4.0);
    let before = q.clone();
    context.change_charts(0.0, &mut q, &mut [], &mut []);
    assert_eq!(q, before);
}

#[track_caller]
fn is_frame(R: &Matrix3<f64>) {
    assert!((R.tr_mul(R) - Matrix3::identity()).norm() < 1e-14, "{R}");
    assert!((R.determinant() - 1.0).abs() < 1e-14);
}

#[test]
fn axes_carry_right_handed_frames_along_their_tangent() {
    let tangent = Vector3::new(1.0, 2.0, -0.5);
    let second = Vector3::new(0.3, 0.1, 2.0);
    for second in [None, Some(second), Some(tangent * 3.0)] {
        let R = frame_along(&tangent, second.as_ref());
        is_frame(&R);
        assert!((R.column(0) - tangent.normalize()).norm() < 1e-15);
    }
    // E₂ in the plane of tangent and second, on its side.
    let R = frame_along(&tangent, Some(&second));
    assert!(R.column(1).dot(&second) > 0.0 && R.column(2).dot(&second).abs() < 1e-15);
    // Without one: E₃ up; for a vertical beam, along e2.
    assert_eq!(frame_along(&Vector3::x(), None), Matrix3::identity());
    assert!(frame_along(&tangent, None).column(2).z > 0.0);
    assert_eq!(frame_along(&Vector3::z(), None).column(2), Vector3::y());

    let pretwisted = StraightLine {
        from: Vector3::new(1.0, 0.0, 0.0),
        to: Vector3::new(1.0, 0.0, 4.0),
        second: Some(Vector3::x()),
        twist: 1.2,
    };
    let (x, R) = pretwisted.at(0.25);
    assert_eq!(x, Vector3::new(1.0, 0.0, 1.0));
    is_frame(&R);
    // Turned by 0.3 about the axis e3 from E₂ = e1.
    assert!((R.column(1) - Vector3::new(0.3_f64.cos(), 0.3_f64.sin(), 0.0)).norm() < 1e-15);

    for angle in [1.5, -1.5] {
        let arc = CircularArc {
            from: Vector3::new(2.0, 0.0, 1.0),
            center: Vector3::new(0.0, 0.0, 3.0),
            axis: Unit::new_normalize(Vector3::z()),
            angle,
            second: Some(Vector3::z()),
        };
        for u in [0.0, 0.4, 1.0] {
            let (x, R) = arc.at(u);
            let (s, c) = (angle * u).sin_cos();
            assert!((x - Vector3::new(2.0 * c, 2.0 * s, 1.0)).norm() < 1e-14);
            is_frame(&R);
            let tangent = Vector3::new(-s, c, 0.0) * angle.signum();
            assert!((R.column(0) - tangent).norm() < 1e-14);
            assert!((R.column(1) - Vector3::z()).norm() < 1e-14);
        }
    }
}

#[test]
fn a_line_makes_nodes_and_elements_in_order() {
    let mut b = ModelBuilder::new();
    let ends = [("a", 0.0), ("b", 6.0)].map(|(name, x)| b.node(name, [x, 0.0, 0.0]).unwrap());
    let axis = straight(&b, ends);
    let made = b.line("l", &axis, ends, &line(2, 3)).unwrap();
    let names: Vec<&str> = made.nodes.iter().map(|&n| b.node_name(n)).collect();
    assert_eq!(names, ["a", "l/1", "l/2", "l/3", "l/4", "l/5", "b"]);
    for (k, &n) in made.nodes.iter().enumerate() {
        assert_eq!(b.position(n), Vector3::new(k as f64, 0.0, 0.0));
    }
    let context = Context::new(b.build().unwrap());
    let [first, last] = [0, 1].map(|k| context.element(made.elements[k]));
    assert_eq!(first, ("l:1", made.nodes[..4].to_vec()));
    assert_eq!(last, ("l:2", made.nodes[3..].to_vec()));
    // Blocks are numbered along the line; elements do not couple across it: the first node meets
    // the last of its element, not the end of the line.
    assert!(context.pattern().find(0, 3).is_some());
    assert_eq!(context.pattern().find(0, 6), None);
}

#[test]
fn a_line_that_does_not_fit_into_memory_is_refused() {
    let mut b = ModelBuilder::new();
    let ends = [0.0, 1.0].map(|x| b.node(format!("{x}"), [x, 0.0, 0.0]).unwrap());
    let axis = straight(&b, ends);
    let error = b
        .line("rod", &axis, ends, &line(1 << 60, 1))
        .unwrap_err()
        .to_string();
    let start =
        "line rod: its 1152921504606846976 elements need about 9223372036854.8 GB of memory, and ";
    assert!(error.starts_with(start), "{error}");
}

/// Sixteen times as many nodes take as long as sixteen questions about fewer, where a search among all nodes
/// for every coordinate takes sixteen times as long: what else runs slows both alike.
#[test]
fn names_and_freedoms_cost_what_a_model_has() {
    let seconds = |count: usize| {
        let mut b = ModelBuilder::new();
        for k in 0..count {
            let node = b.node(format!("n{k}"), [k as f64, 0.0, 0.0]).unwrap();
            mass(&mut b, node);
        }
        let context = Context::new(b.build().unwrap());
        let time = || {
            let start = Instant::now();
            for _ in 0..8000 / count {
                assert_eq!(context.mobility().freedoms, 6 * count);
                let names: Vec<String> = (0..6 * count).map(|i| context.name(i)).collect();
                let last = format!("node n{}, rotation about e3", count - 1);
                assert_eq!(names.last(), Some(&last));
            }
            start.elapsed().as_secs_f64()
        };
        (0..3).map(|_| time()).fold(f64::INFINITY, f64::min)
    };
    let growth = seconds(8000) / seconds(500);
    assert!(growth < 4.0, "{growth}");
}

/// x = u q with an input u.
#[derive(Clone)]
struct Ratio;

impl Map<2, 1> for Ratio {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 2>) -> SVector<S, 1> {
        SVector::<S, 1>::new(q[0] * q[1])
    }
}

/// A map that reads an input as a prescribed coordinate is evaluated anew when the input changes, also
/// at the same point.
#[test]
fn maps_read_inputs() {
    let mut b = ModelBuilder::new();
    let ratio = b.input(2.0);
    let q = b.coordinates("q", &[Quantity::Other]).unwrap();
    let u = b.coordinates("u", &[Quantity::Other]).unwrap();
    b.prescribe_coordinate(u, 0, ratio);
    let x = b
        .mapped_coordinates("x", &[Quantity::Other], Ratio.boxed(), &[q, u])
        .unwrap();
    let law = CoordinateLaw {
        k: 3.0,
        ..CoordinateLaw::default()
    };
    let spring = CoordinateSpring::new(law).unwrap();
    b.element("spring", spring, &[x]).unwrap();
    let mut context = Context::new(b.build().unwrap());
    let at = Point::statics(0.0, &[0.5]);
    for u in [2.0, 2.0, -1.0] {
        context.set_input(ratio, u);
        let mut r = [0.0];
        context.evaluate(at, Evaluation::residual(&mut r)).unwrap();
        assert_eq!(r, [-3.0 * u * u * 0.5]);
        assert_eq!(context.coordinate(x, 0), Some([0.5 * u, 0.0, 0.0]));
    }
}

/// The paths from a coordinate that follows from two, which follow from two each, are as many as Fibonacci's numbers.
#[test]
fn coordinates_may_follow_from_others_along_many_paths() {
    let (mut b, ends) = simple();
    let mut x = [0, 1].map(|k| b.coordinates(format!("x{k}"), &[Quantity::Angle]).unwrap());
    for k in 2..90 {
        let map = Ratio.boxed();
        let next = b.mapped_coordinates(format!("x{k}"), &[Quantity::Angle], map, &x);
        x = [x[1], next.unwrap()];
    }
    let joint = Revolute::new([0.0, 0.0, 1.0]).unwrap();
    let hinge = b.add_joint_frame("hinge", ends[1], joint, &x[1..]);
    let child = b.node("child", [1.0, 0.0, 0.0]).unwrap();
    mass(&mut b, child);
    b.close(hinge.unwrap(), child).unwrap();
    b.build().unwrap();
}

#[test]
fn a_frame_may_coincide_with_several_by_multipliers() {
    let mut b = ModelBuilder::new();
    let frames = ["a", "b", "c"].map(|name| b.node(name, [0.0; 3]).unwrap());
    frames.iter().for_each(|frame| mass(&mut b, *frame));
    for child in &frames[1..] {
        b.close_by(frames[0], *child, Closure::Multipliers).unwrap();
    }
    let model = b.build().unwrap();
    // Behind the frames.
    let names: Vec<&str> = model.nodes()[3..].iter().map(|n| n.name()).collect();
    assert_eq!(names, ["multipliers of a and b", "multipliers of a and c"]);
    assert_eq!(model.mobility().freedoms, 6);
}

/// A value may be as large as positions stay exact with it: a length in the size of the model, a number in one.
#[test]
fn initial_values_are_measured_in_their_quantities() {
    let start = |quantity: Quantity, value: f64| {
        let mut b = ModelBuilder::new();
        for (name, x) in [("a", 0.0), ("b", 1e-6)] {
            let node = b.node(name, [x, 0.0, 0.0]).unwrap();
            mass(&mut b, node);
        }
        let q = b.coordinates("q", &[quantity]).unwrap();
        b.element("idle", Idle(1), &[q]).unwrap();
        b.start(q, 0, value);
        b.build().is_ok()
    };
    assert!(start(Quantity::Other, 5.0) && start(Quantity::Angle, 5.0));
    assert!(start(Quantity::Length, 4.0) && !start(Quantity::Length, 5.0));
    assert!(!start(Quantity::Length, f64::NAN));
}
