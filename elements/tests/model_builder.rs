//! Building a model: what is refused and with which words, axes, numbering, supports.

#![allow(non_snake_case)]

mod common;

use common::{Offset, Twin, section};
use nalgebra::{Matrix3, Unit, Vector3};
use pullback_elements::beam::{Beam, BeamError};
use pullback_elements::element::{Element, ElementError, Motion, Response};
use pullback_elements::load::{NodalLoad, Which};
use pullback_elements::model::{
    Arc, Axis, Dof, Line, Model, ModelBuilder, ModelError, NodeId, Straight, frame_along,
};
use pullback_elements::time::{Constant, Proportional};
use pullback_manifold::map::Map;
use pullback_manifold::system::{Evaluation, Kind, Point, System, SystemError};

fn straight(b: &ModelBuilder, ends: [NodeId; 2]) -> Straight {
    Straight {
        from: b.place(ends[0]),
        to: b.place(ends[1]),
        second: None,
        twist: 0.0,
    }
}

fn line(elements: usize, order: usize) -> Line {
    Line {
        elements,
        order,
        section: section(),
    }
}

/// A line of one element between two named nodes.
fn beam(b: &mut ModelBuilder, name: &str, ends: [NodeId; 2]) {
    let axis = straight(b, ends);
    b.line(name, &axis, ends, &line(1, 1)).unwrap();
}

/// Two nodes a metre apart and a beam.
fn simple() -> (ModelBuilder, [NodeId; 2]) {
    let mut b = ModelBuilder::new();
    let ends = [
        b.node("a", [0.0; 3]).unwrap(),
        b.node("b", [1.0, 0.0, 0.0]).unwrap(),
    ];
    beam(&mut b, "beam", ends);
    (b, ends)
}

#[track_caller]
fn says<T>(outcome: Result<T, ModelError>, message: &str) {
    let Err(error) = outcome else {
        panic!("accepted");
    };
    assert_eq!(error.to_string(), message);
}

/// Any number of coordinates, no force.
struct Idle(usize);

impl Element for Idle {
    fn dim(&self) -> usize {
        self.0
    }

    fn evaluate(&self, _: &Motion<'_>, _: &mut Response<'_>) -> Result<(), ElementError> {
        Ok(())
    }
}

#[test]
fn nodes_that_cannot_be() {
    says(
        ModelBuilder::new().build(),
        "a model needs at least one node",
    );
    let mut b = ModelBuilder::new();
    let a = b.node("a", [1.0, 2.0, 3.0]).unwrap();
    b.node("b", [0.0; 3]).unwrap();
    says(
        b.node("a", [0.0; 3]),
        "node a is defined twice; give each node its own name",
    );
    says(
        b.coordinates("b", &[Kind::Angle]),
        "node b is defined twice; give each node its own name",
    );
    says(
        b.node("c", [0.0, f64::NAN, 1.0]),
        "node c has a coordinate that is not finite: [0.0, NaN, 1.0]",
    );
    assert_eq!(b.find("a"), Ok(a));
    assert_eq!(
        (b.node_name(a), b.place(a)),
        ("a", Vector3::new(1.0, 2.0, 3.0))
    );
    says(b.find("x"), "there is no node x; known nodes: a, b");
    for k in 0..20 {
        b.node(format!("n{k}"), [0.0; 3]).unwrap();
    }
    let error = b.find("x").unwrap_err().to_string();
    assert!(error.ends_with("n8, n9, ..."), "{error}");
}

#[test]
fn elements_that_do_not_fit() {
    let (mut b, ends) = simple();
    says(
        b.element("spring", Idle(9), &ends),
        "element spring has 9 coordinates, but its nodes (a, b) have 12 together",
    );
    says(
        b.element("net", Idle(102), &[ends[0]; 17]),
        "element net has 17 nodes; at most 16 are possible",
    );
    let mut other = ModelBuilder::new();
    for k in 0..5 {
        other.node(format!("{k}"), [0.0; 3]).unwrap();
    }
    let foreign = other.find("4").unwrap();
    says(
        b.element("stray", Idle(6), &[foreign]),
        "element stray refers to a node of another model builder",
    );
    says(
        b.mapped_node("slave", [0.0; 3], Twin.boxed(), &[foreign]),
        "joint at node slave refers to a node of another model builder",
    );
    b.prescribe(foreign, Dof::X, Constant(0.0));
    says(
        b.build(),
        "a support or driven motion refers to a node of another model builder",
    );
}

#[test]
fn joints_that_do_not_fit() {
    let (mut b, ends) = simple();
    says(
        b.mapped_node("slave", [0.0; 3], Twin.boxed(), &ends),
        "the map of the joint at node slave takes 6 coordinates to 6, but it must take the 12 of \
         its masters (a, b) to 6",
    );
    let slave = b
        .mapped_node("slave", [0.0; 3], Twin.boxed(), &ends[..1])
        .unwrap();
    says(
        b.mapped_node("second", [0.0; 3], Twin.boxed(), &[slave]),
        "node second cannot follow node slave, which follows other nodes itself; compose the two \
         maps and name the masters of slave",
    );
    b.support(slave, &[Dof::RY]);
    let load = NodalLoad::new(Which::DeadForce, [1.0; 3], Constant(1.0));
    b.element("load", load, &[slave]).unwrap();
    says(
        b.build(),
        "node slave, rotation about e2 follows from other nodes through a joint and cannot be \
         prescribed; prescribe a coordinate of its masters a",
    );
}

#[test]
fn lines_that_do_not_fit() {
    let mut b = ModelBuilder::new();
    let ends = [
        b.node("a", [0.0; 3]).unwrap(),
        b.node("b", [1.0, 0.0, 0.0]).unwrap(),
    ];
    let twin = b.node("twin", [0.0; 3]).unwrap();
    let axis = straight(&b, ends);
    says(
        b.line("l", &axis, ends, &line(0, 1)),
        "line l: needs at least one element",
    );
    says(
        b.line("l", &axis, ends, &line(2, 4)),
        "line l: elements of order 4 do not exist; choose 1, 2 or 3",
    );
    says(
        b.line("l", &axis, [ends[0], twin], &line(2, 1)),
        "line l: its end is [1.0, 0.0, 0.0], but node twin stands 1.000e0 away at [0.0, 0.0, 0.0]",
    );
    says(
        b.line("l", &axis, [ends[1], ends[1]], &line(2, 1)),
        "line l: its start is [0.0, 0.0, 0.0], but node b stands 1.000e0 away at [1.0, 0.0, 0.0]",
    );
    let point = straight(&b, [ends[0], twin]);
    let error = b.line("l", &point, [ends[0], twin], &line(1, 1));
    let source = BeamError::ZeroLength { at: [0.0; 3] };
    assert_eq!(
        error.clone().unwrap_err(),
        ModelError::Beam {
            element: "l:1".to_owned(),
            source
        }
    );
    says(
        error,
        "element l:1: its length is zero: nodes at [0.0, 0.0, 0.0] coincide",
    );
}

#[test]
fn supports_that_cannot_be() {
    let (mut b, ends) = simple();
    b.support(ends[0], &Dof::ALL);
    b.prescribe(ends[0], Dof::RZ, Proportional(1.0));
    says(
        b.build(),
        "node a, rotation about e3 is prescribed twice; remove one of the supports or driven \
         motions that name it",
    );
    let (mut b, ends) = simple();
    ends.iter().for_each(|&n| b.support(n, &Dof::ALL));
    says(
        b.build(),
        "all coordinates are prescribed; there is nothing to solve for",
    );
    // A coordinate that a node does not have is not that of the next node.
    let (mut b, ends) = simple();
    let angle = b.coordinates("hinge", &[Kind::Angle]).unwrap();
    b.element("hinge spring", Idle(7), &[angle, ends[0]])
        .unwrap();
    b.support(angle, &[Dof::Y]);
    says(
        b.build(),
        "node hinge has 1 coordinates, so there is no Y to prescribe",
    );
}

#[test]
fn nodes_that_nothing_holds_on_to() {
    let (mut b, _) = simple();
    let lost = b.node("lost", [5.0; 3]).unwrap();
    let load = NodalLoad::new(Which::DeadForce, [1.0; 3], Constant(1.0));
    b.element("load", load, &[lost]).unwrap();
    says(
        b.build(),
        "node lost carries no element (loads do not count); connect it or remove it",
    );
    let (mut b, ends) = simple();
    let offset = Offset([0.0, 1.0, 0.0]).boxed();
    let slave = b
        .mapped_node("slave", [1.0, 1.0, 0.0], offset, &ends[1..])
        .unwrap();
    // Nothing at all at a mapped node is a mistake; a load alone is what an offset is for.
    let load = || NodalLoad::new(Which::DeadForce, [1.0, 2.0, 4.0], Constant(1.0));
    b.element("load", load(), &[slave]).unwrap();
    let mut model = b.build().unwrap();
    let n = model.pattern().dim();
    assert_eq!(n, 12);
    let (q, mut r) = (vec![0.0; n], vec![0.0; n]);
    let at = Point {
        t: 0.0,
        q: &q,
        v: &[],
        a: &[],
    };
    model.evaluate(at, Evaluation::residual(&mut r)).unwrap();
    // The force and its moment c × f about the master, c = (0, 1, 0).
    assert_eq!(r[6..], [1.0, 2.0, 4.0, 4.0, 0.0, -1.0]);
    let (mut b, ends) = simple();
    b.mapped_node("slave", [1.0, 1.0, 0.0], Twin.boxed(), &ends[1..])
        .unwrap();
    says(
        b.build(),
        "node slave carries no element (loads do not count); connect it or remove it",
    );
}

fn built(support: impl Fn(&mut ModelBuilder, [NodeId; 2])) -> Model {
    let (mut b, ends) = simple();
    support(&mut b, ends);
    b.build().unwrap()
}

#[test]
fn structures_that_can_move_as_rigid_bodies() {
    let message = |model: Model| model.check_supports().unwrap_err().to_string();
    let starts = "the part of the structure that contains node a is not supported: it can still \
                  move as a rigid body (";
    let ends = "); add supports that prevent this";
    // A direction has two signs.
    let motion = |model: Model| {
        let message = message(model);
        let inner = message
            .strip_prefix(starts)
            .and_then(|m| m.strip_suffix(ends));
        inner.expect("a motion").replace('-', "")
    };
    assert!(
        built(|b, n| b.support(n[0], &Dof::ALL))
            .check_supports()
            .is_ok()
    );
    let slides = built(|b, n| b.support(n[0], &[Dof::Y, Dof::Z, Dof::RX, Dof::RY, Dof::RZ]));
    assert_eq!(motion(slides), "translation along (1.000, 0.000, 0.000)");
    // Both ends pinned: it can spin about its axis, which passes through the middle.
    let spins = built(|b, n| n.iter().for_each(|&n| b.support(n, &Dof::TRANSLATIONS)));
    assert_eq!(
        motion(spins),
        "rotation about the direction (1.000, 0.000, 0.000) through (0.5000, 0.0000, 0.0000)"
    );
    // A hinge at b about e3: the axis passes through b, not through the centre.
    let swings = built(|b, n| {
        b.support(n[1], &[Dof::X, Dof::Y, Dof::Z, Dof::RX, Dof::RY]);
    });
    assert_eq!(
        motion(swings),
        "rotation about the direction (0.000, 0.000, 1.000) through (1.0000, 0.0000, 0.0000)"
    );
    assert!(message(built(|_, _| ())).starts_with(starts));
    // Every part by itself; a joint connects, a load does not.
    let (mut b, ends) = simple();
    b.support(ends[0], &Dof::ALL);
    let second = [[0.0, 3.0, 0.0], [1.0, 3.0, 0.0]].map(|p| b.node(format!("{p:?}"), p).unwrap());
    beam(&mut b, "second", second);
    let error = b.build().unwrap().check_supports().unwrap_err();
    assert!(matches!(&error, ModelError::Unsupported { node, .. } if node == "[0.0, 3.0, 0.0]"));
    let (mut b, ends) = simple();
    b.support(ends[0], &Dof::ALL);
    let offset = Offset([0.0, 1.0, 0.0]).boxed();
    let slave = b
        .mapped_node("slave", [1.0, 1.0, 0.0], offset, &ends[1..])
        .unwrap();
    let far = b.node("far", [1.0, 2.0, 0.0]).unwrap();
    beam(&mut b, "second", [slave, far]);
    assert!(b.build().unwrap().check_supports().is_ok());
}

#[test]
fn unknowns_have_numbers_names_and_kinds() {
    let (mut b, ends) = simple();
    let hinge = b.coordinates("hinge", &[Kind::Angle, Kind::Other]).unwrap();
    // Six coordinates that a joint releases are no frame: their charts are never changed.
    let six = b.coordinates("six", &[Kind::Other; 6]).unwrap();
    b.element("idle", Idle(14), &[ends[1], hinge, six]).unwrap();
    b.support(ends[0], &[Dof::X, Dof::RX]);
    let mut model = b.build().unwrap();
    assert_eq!(model.pattern().dim(), 4 + 6 + 2 + 6);
    assert_eq!(model.unknown(ends[0], Dof::X), None);
    assert_eq!(model.unknown(ends[0], Dof::Y), Some(0));
    assert_eq!(model.unknown(ends[1], Dof::RZ), Some(9));
    assert!(model.is_prescribed(ends[0], Dof::RX) && !model.is_prescribed(ends[0], Dof::RY));
    assert_eq!(model.name(0), "node a, displacement along e2");
    assert_eq!(model.name(9), "node b, rotation about e3");
    assert_eq!(model.name(11), "hinge, coordinate 2");
    assert_eq!(model.name(12), "six, coordinate 1");
    let kinds = [0, 2, 9, 10, 11, 12].map(|i| model.kind(i));
    assert_eq!(
        kinds,
        [
            Kind::Length,
            Kind::Angle,
            Kind::Angle,
            Kind::Angle,
            Kind::Other,
            Kind::Other
        ]
    );
    assert_eq!(model.frames().count(), 2);
    assert_eq!(model.find("hinge"), Some(hinge));
    assert_eq!(model.find("none"), None);
    assert_eq!(model.length(), 1.0);
    assert_eq!(model.element_count(), 2);
    let mut q = vec![0.0; 18];
    q[12..].fill(4.0);
    let before = q.clone();
    model.change_charts(0.0, &mut q, &mut [], &mut []);
    assert_eq!(q, before);
    // Largest entries: lengths are measured by the model.
    let mut r = vec![0.0; 18];
    (r[1], r[8]) = (-3.0, 2.0);
    let largest = model.largest_entries(&r, 2);
    assert_eq!(
        largest[0],
        ("node a, displacement along e3".to_owned(), -3.0)
    );
    assert_eq!(largest[1], ("node b, rotation about e2".to_owned(), 2.0));
}

/// Forces that are not finite, and a map with an edge.
struct Broken;

impl Element for Broken {
    fn dim(&self) -> usize {
        6
    }

    fn evaluate(&self, _: &Motion<'_>, out: &mut Response<'_>) -> Result<(), ElementError> {
        out.r[4] = f64::NAN;
        Ok(())
    }
}

struct Bounded;

impl Map<6, 6> for Bounded {
    fn phi<S: pullback_manifold::scalar::Scalar>(
        &self,
        _t: S,
        q: &nalgebra::SVector<S, 6>,
    ) -> nalgebra::SVector<S, 6> {
        *q
    }

    fn margin(&self, q: &nalgebra::SVector<f64, 6>) -> f64 {
        1.0 - q[0]
    }
}

#[test]
fn points_outside_a_domain_are_refused_by_name() {
    fn evaluate(model: &mut Model, q: &[f64]) -> String {
        let mut r = vec![0.0; q.len()];
        let at = Point {
            t: 0.0,
            q,
            v: &[],
            a: &[],
        };
        let outcome = model.evaluate(at, Evaluation::residual(&mut r));
        outcome.map_or_else(|e: SystemError| e.to_string(), |()| "fine".to_owned())
    }
    let (b, _) = simple();
    let mut model = b.build().unwrap();
    let mut q = vec![0.0; 12];
    (q[3], q[9]) = (6.283, 6.283);
    assert_eq!(
        evaluate(&mut model, &q),
        "beam:1 left the domain of its chart (margin 1.853e-4); take smaller steps"
    );
    let (mut b, ends) = simple();
    b.element("broken", Broken, &ends[1..]).unwrap();
    assert_eq!(
        evaluate(&mut b.build().unwrap(), &[0.0; 12]),
        "node b, rotation about e2 gives a value that is not finite"
    );
    let (mut b, ends) = simple();
    let slave = b
        .mapped_node("slave", [1.0, 0.0, 0.0], Bounded.boxed(), &ends[1..])
        .unwrap();
    b.element("idle", Idle(6), &[slave]).unwrap();
    let mut model = b.build().unwrap();
    let mut q = vec![0.0; 12];
    assert_eq!(evaluate(&mut model, &q), "fine");
    q[6] = 1.5;
    assert_eq!(
        evaluate(&mut model, &q),
        "joint at node slave left the domain of its chart (margin -5.000e-1); take smaller steps"
    );
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

    let pretwisted = Straight {
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
        let arc = Arc {
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
    let ends = [
        b.node("a", [0.0; 3]).unwrap(),
        b.node("b", [6.0, 0.0, 0.0]).unwrap(),
    ];
    let axis = straight(&b, ends);
    let made = b.line("l", &axis, ends, &line(2, 3)).unwrap();
    let names: Vec<&str> = made.nodes.iter().map(|&n| b.node_name(n)).collect();
    assert_eq!(names, ["a", "l/1", "l/2", "l/3", "l/4", "l/5", "b"]);
    for (k, &n) in made.nodes.iter().enumerate() {
        assert_eq!(b.place(n), Vector3::new(k as f64, 0.0, 0.0));
    }
    let model = b.build().unwrap();
    assert_eq!(
        model.element(made.elements[0]),
        ("l:1", made.nodes[..4].to_vec())
    );
    assert_eq!(
        model.element(made.elements[1]),
        ("l:2", made.nodes[3..].to_vec())
    );
    // Elements do not couple across the line: no block between the first and the last node.
    assert_eq!(model.pattern().find(0, 1), None);
    assert!(
        Beam::along(
            &[Vector3::zeros(), Vector3::x()],
            &|_| Matrix3::identity(),
            &section()
        )
        .is_ok()
    );
}
