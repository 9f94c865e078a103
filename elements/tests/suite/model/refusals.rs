//! What a model refuses, and with which words.

use crate::support::*;

#[test]
fn nodes_that_cannot_be() {
    refused! { ModelBuilder::new().build() => "a model needs at least one node" }
    let mut b = ModelBuilder::new();
    let a = b.node("a", [1.0, 2.0, 3.0]).unwrap();
    b.node("b", [0.0; 3]).unwrap();
    refused! {
        b.node("a", [0.0; 3]) => "node a is defined twice; give each node its own name",
        b.coordinates("b", &[Quantity::Angle]) =>
            "node b is defined twice; give each node its own name",
        b.node("c", [0.0, f64::NAN, 1.0]) =>
            "node c has a coordinate that is not finite: [0.0, NaN, 1.0]",
    }
    assert_eq!((b.find("a"), b.node_name(a)), (Ok(a), "a"));
    assert_eq!(b.position(a), Vector3::new(1.0, 2.0, 3.0));
    refused! { b.find("x") => "there is no node x; known nodes: a, b" }
    for k in 0..20 {
        b.node(format!("n{k}"), [0.0; 3]).unwrap();
    }
    let error = b.find("x").unwrap_err().to_string();
    assert!(error.ends_with("n8, n9, ..."), "{error}");
}

#[test]
fn elements_that_do_not_fit() {
    let (mut b, ends) = simple();
    refused! {
        b.element("spring", Idle(9), &ends) =>
            "element spring has 9 coordinates, but its nodes (a, b) have 12 together",
        b.element("net", Idle(102), &[ends[0]; 17]) =>
            "element net reads 17 nodes; at most 16 are possible",
    }
    let mut other = ModelBuilder::new();
    for k in 0..5 {
        other.node(format!("{k}"), [0.0; 3]).unwrap();
    }
    let foreign = other.find("4").unwrap();
    refused! {
        b.element("stray", Idle(6), &[foreign]) =>
            "element stray refers to a node of another model builder",
        b.mapped_node("dependent", [0.0; 3], Twin.boxed(), &[foreign]) =>
            "joint at node dependent refers to a node of another model builder",
    }
    let interpolation = Interpolation::Total;
    let axis = straight(&b, ends);
    let mut along = |ends, relative_to| {
        let line = BeamLine {
            relative_to,
            ..line(2, 1)
        };
        b.line("l", &axis, ends, &line)
    };
    let of_line = "line l refers to a node of another model builder";
    refused! {
        along([ends[0], foreign], None) => of_line,
        along(ends, Some(foreign)) =>
            "joint at node l/1 refers to a node of another model builder",
        b.line_through("l", &axis, &[ends[0], foreign], &line(1, 1)) => of_line,
        b.offset("o", foreign, [0.0; 3]) =>
            "joint at node o refers to a node of another model builder",
        b.relative_node("o", foreign, [0.0; 3]) =>
            "joint at node o refers to a node of another model builder",
        b.slide("o", &[ends[0], foreign], 0.0, interpolation) =>
            "joint at node o refers to a node of another model builder",
        b.gear([foreign, ends[0]], 2.0) => "a gear refers to a node of another model builder",
    }
    // Six coordinates are no frame.
    let six = [Quantity::Length; 6];
    let six = b.coordinates("six", &six).unwrap();
    let body = RigidBody::new(1.0, Matrix3::identity(), Vector3::zeros()).unwrap();
    let hinge = Revolute::new([0.0, 0.0, 1.0]).unwrap();
    let none = "reads node six as a frame, but it has 6 coordinates";
    refused! {
        b.offset("o", six, [0.0; 3]) => &format!("joint at node o {none}")[..],
        b.attach("o", six, hinge) => &format!("joint at node o {none}")[..],
        b.attach("a", ends[0], hinge) => "node a is defined twice; give each node its own name",
        b.element("body", body, &[six]) => &format!("element body {none}")[..],
    }
    // Nothing is left of joints that were refused.
    assert!(b.find("o angle").is_err() && b.find("a angle").is_err());
    b.start(foreign, 0, 1.0);
    refused! { b.build() => "an initial value refers to a node of another model builder" }
    // Also where nothing else is free.
    for held in [&[][..], &Dof::ALL] {
        let (mut b, ends) = simple();
        ends.iter().for_each(|&end| b.support(end, held));
        b.prescribe(foreign, Dof::X, Constant(0.0));
        refused! {
            b.build() => "a support or prescribed motion refers to a node of another model builder",
        }
    }
}

#[test]
fn joints_that_do_not_fit() {
    let (mut b, ends) = simple();
    refused! {
        b.mapped_node("dependent", [0.0; 3], Twin.boxed(), &ends) =>
            "the map of the joint at node dependent takes 6 coordinates to 6, but it must take the 12 of \
             its parents (a, b) to 6",
        b.mapped_node_along("dependent", [0.0; 3], Twin.boxed(), &[]) =>
            "the map of the joint at node dependent needs a set of parents for each segment (1) or one for all, and has 0",
        b.mapped_node_along("dependent", [0.0; 3], Twin.boxed(), &[&ends[..1]; 2]) =>
            "the map of the joint at node dependent needs a set of parents for each segment (1) or one for all, and has 2",
    }
    let dependent = b
        .mapped_node("dependent", [0.0; 3], Twin.boxed(), &ends[..1])
        .unwrap();
    b.support(dependent, &[Dof::RY]);
    let load = NodalLoad::new(LoadKind::DeadForce, [1.0; 3], Constant(1.0));
    b.element("load", load, &[dependent]).unwrap();
    refused! {
        b.build() =>
            "node dependent, rotation about e2 follows from other nodes through a joint and cannot be \
             prescribed; prescribe a coordinate of its parents a",
    }
}

/// c² + s² = 1.
#[derive(Clone)]
struct Circle;

impl Implicit<2, 1> for Circle {
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, 2>) -> SVector<S, 1> {
        SVector::<S, 1>::new(x[0] * x[0] + x[1] * x[1] - 1.0)
    }
}

/// What is offered instead of a coordinate that follows can be prescribed, and not what it is picked from.
#[test]
fn coordinates_that_follow_from_coordinates_that_follow() {
    let cases = [
        (
            Choice::Split,
            "bead x follows from the equations that bead is solved from and cannot be \
             prescribed; add the equation x - f(t) = 0 of its motion to them, or let one of the \
             coordinates be independent for good (`Choice::Fixed`) and prescribe that",
        ),
        (
            Choice::Fixed,
            "bead x follows from other nodes through a joint and cannot be prescribed; \
             prescribe a coordinate of its parents q",
        ),
    ];
    for (choice, message) in cases {
        let (mut b, _) = simple();
        let map = ImplicitMap::of(Circle, 1, 0.0, [0.8, 0.6], choice).unwrap();
        let q = b.coordinates("q", &[Quantity::Other]).unwrap();
        let both = b.mapped_coordinates("bead", &[Quantity::Length; 2], Box::new(map), &[q]);
        let pick = Linear::<2, 1>::pick(0, 0.8).boxed();
        let x = b.mapped_coordinates("bead x", &[Quantity::Length], pick, &[both.unwrap()]);
        b.prescribe_coordinate(x.unwrap(), 0, Constant(0.1));
        refused! { b.build() => message }
    }
}

/// Where one set of equations has no solution, what another one leaves is not the largest residual.
#[test]
fn equations_without_a_solution_have_no_residual() {
    let (mut b, _) = simple();
    for name in ["first", "second"] {
        let map = ImplicitMap::of(Circle, 1, 0.0, [0.8, 0.6], Choice::Fixed).unwrap();
        let q = b.coordinates(format!("q of {name}"), &[Quantity::Other]);
        let both = b.mapped_coordinates(name, &[Quantity::Length; 2], Box::new(map), &[q.unwrap()]);
        b.element(name, Idle(2), &[both.unwrap()]).unwrap();
    }
    let mut context = Context::new(b.build().unwrap());
    let mut q = vec![0.0; context.pattern().dim()];
    context.configure(Point::statics(0.0, &q)).unwrap();
    assert!(context.violation().unwrap() < 1e-15);
    for name in ["q of first", "q of second"] {
        let u = (0..q.len()).find(|&u| context.name(u) == name).unwrap();
        q[u] = 7.0;
        context.configure(Point::statics(0.0, &q)).unwrap_err();
        assert!(context.violation().unwrap().is_nan());
        q[u] = 0.0;
    }
}

#[test]
fn shafts_against_each_other_have_no_direction_of_tilt() {
    let e = [0.3, -0.2, 0.9];
    let couple = |by: f64| ConstantVelocity::new([e, e.map(|x| by * x)]);
    refused! {
        couple(-2.0) =>
            "its two axes are opposite: one shaft would be turned by 180° against the other, and in \
             which direction is not known; reverse one axis",
    }
    assert!(couple(2.0).is_ok());
}

#[test]
fn lines_that_do_not_fit() {
    let mut b = ModelBuilder::new();
    let ends = [("a", 0.0), ("b", 1.0)].map(|(name, x)| b.node(name, [x, 0.0, 0.0]).unwrap());
    let twin = b.node("twin", [0.0; 3]).unwrap();
    let axis = straight(&b, ends);
    refused! {
        b.line("l", &axis, ends, &line(0, 1)) => "line l: needs at least one element",
        b.line("l", &axis, ends, &line(2, 4)) =>
            "line l: elements of order 4 do not exist; choose 1, 2 or 3",
        b.line("l", &axis, [ends[0], twin], &line(2, 1)) =>
            "line l: its end is [1.0, 0.0, 0.0], but node twin stands 1.000e0 away at [0.0, 0.0, 0.0]",
        b.line("l", &axis, [ends[1], ends[1]], &line(2, 1)) =>
            "line l: its start is [0.0, 0.0, 0.0], but node b stands 1.000e0 away at [1.0, 0.0, 0.0]",
    }
    let point = straight(&b, [ends[0], twin]);
    refused! {
        b.line("l", &point, [ends[0], twin], &line(1, 1)) =>
            "element l:1: its length is zero: nodes at [0.0, 0.0, 0.0] coincide",
    }
}

#[test]
fn supports_that_cannot_be() {
    let (mut b, ends) = simple();
    b.support(ends[0], &Dof::ALL);
    b.prescribe(ends[0], Dof::RZ, Proportional(1.0));
    refused! {
        b.build() =>
            "node a, rotation about e3 is prescribed twice; remove one of the supports or prescribed \
             motions that name it",
    }
    // A coordinate that a node does not have is not that of the next node.
    let (mut b, ends) = simple();
    let angle = b.coordinates("hinge", &[Quantity::Angle]).unwrap();
    b.element("hinge spring", Idle(7), &[angle, ends[0]])
        .unwrap();
    b.support(angle, &[Dof::Y]);
    refused! { b.build() => "node hinge has 1 coordinates, so there is no number 2 to prescribe" }
}

#[test]
fn nodes_that_nothing_holds_on_to() {
    let (mut b, _) = simple();
    let lost = b.node("lost", [5.0; 3]).unwrap();
    let load = NodalLoad::new(LoadKind::DeadForce, [1.0; 3], Constant(1.0));
    b.element("load", load, &[lost]).unwrap();
    refused! {
        b.build() => "node lost carries no element (loads do not count); connect it or remove it",
    }
    let (mut b, ends) = simple();
    let offset = GrowingOffset([0.0, 1.0, 0.0]).boxed();
    let dependent = b
        .mapped_node("dependent", [1.0, 1.0, 0.0], offset, &ends[1..])
        .unwrap();
    // A load alone is what an offset is for, or nothing at all: a position to look at.
    let load = || NodalLoad::new(LoadKind::DeadForce, [1.0, 2.0, 4.0], Constant(1.0));
    b.element("load", load(), &[dependent]).unwrap();
    let mut context = Context::new(b.build().unwrap());
    let n = context.pattern().dim();
    assert_eq!(n, 12);
    let (q, mut r) = (vec![0.0; n], vec![0.0; n]);
    let at = Point::statics(0.0, &q);
    context.evaluate(at, Evaluation::residual(&mut r)).unwrap();
    // The force and its moment c × f about the parent, c = (0, 1, 0).
    assert_eq!(r[6..], [1.0, 2.0, 4.0, 4.0, 0.0, -1.0]);
    let (mut b, ends) = simple();
    b.mapped_node("dependent", [1.0, 1.0, 0.0], Twin.boxed(), &ends[1..])
        .unwrap();
    Context::new(b.build().unwrap());
}

/// Forces that are not finite, and a map with an edge.
struct Broken;

impl Element for Broken {
    fn dim(&self) -> usize {
        6
    }

    fn evaluate(&self, _: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        out.r[4] = f64::NAN;
        Ok(())
    }
}

#[derive(Clone)]
struct Bounded;

impl Map<6, 6> for Bounded {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 6>) -> SVector<S, 6> {
        let mut x = *q;
        x[1] = (q[1] + 1.0).sqrt();
        x
    }

    fn domain(&self, _t: f64, q: &SVector<f64, 6>) -> Result<f64, DomainError> {
        DomainError::within(1.0 - q[0], CHART_EDGE)
    }
}

#[test]
fn points_outside_a_domain_are_refused_by_name() {
    fn evaluate(context: &mut Context, q: &[f64]) -> Result<(), SystemError> {
        let mut r = vec![0.0; q.len()];
        context.evaluate(Point::statics(0.0, q), Evaluation::residual(&mut r))
    }
    let (b, _) = simple();
    let mut context = Context::new(b.build().unwrap());
    let mut q = vec![0.0; 12];
    let psi = std::f64::consts::TAU - 2e-4;
    (q[3], q[9]) = (psi, psi);
    refused! {
        evaluate(&mut context, &q) =>
            "element beam:1 left the range of its coordinates: it moved or turned too far in one step, or a rotation of \
             which only a part is held or prescribed came near a whole turn; take smaller steps, or hold or \
             prescribe the rest of that rotation",
    }
    let (mut b, ends) = simple();
    b.element("broken", Broken, &ends[1..]).unwrap();
    refused! {
        evaluate(&mut Context::new(b.build().unwrap()), &[0.0; 12]) =>
            "node b, rotation about e2 gives a value that is not finite: an input, or a function of a \
             joint, an element or a load, has no value or derivative there (`check` names it)",
    }
    let (mut b, ends) = simple();
    let dependent = b
        .mapped_node("dependent", [1.0, 0.0, 0.0], Bounded.boxed(), &ends[1..])
        .unwrap();
    b.element("idle", Idle(6), &[dependent]).unwrap();
    let mut model = Context::new(b.build().unwrap());
    let mut q = vec![0.0; 12];
    evaluate(&mut model, &q).unwrap();
    q[7] = -2.0;
    refused! {
        evaluate(&mut model, &q) =>
            "joint at node dependent gives a value that is not finite: an input, or a function of a joint, an \
             element or a load, has no value or derivative there (`check` names it)",
    }
    q[6] = 1.5;
    refused! {
        evaluate(&mut model, &q) =>
            "joint at node dependent left the range of its coordinates: it moved or turned too far in one step, or a rotation of \
             which only a part is held or prescribed came near a whole turn; take smaller steps, or hold or \
             prescribe the rest of that rotation",
    }
}

#[test]
fn evaluations_that_a_point_does_not_hold_are_refused() {
    let (b, _) = simple();
    let mut context = Context::new(b.build().unwrap());
    let (n, values) = (context.pattern().dim(), context.pattern().len());
    let mut evaluate = |[q, v, a, r, S]: [usize; 5], weights: Weights| {
        let (zero, mut r, mut S) = (vec![0.0; 2 * n], vec![0.0; r], vec![0.0; S]);
        let at = point(0.0, [&zero[..q], &zero[..v], &zero[..a]]);
        context.evaluate(at, Evaluation::with_tangent(&mut r, weights, &mut S))
    };
    let STATIC = Weights::STATIC;
    let wrong = |what: &str, expected: usize, found: usize| {
        format!("{what}: expected {expected} entries, got {found}")
    };
    for m in [n - 1, n + 1] {
        refused! {
            evaluate([m, 0, 0, n, values], STATIC) => wrong("coordinates q", n, m),
            evaluate([n, m, n, n, values], STATIC) => wrong("velocities v", n, m),
            evaluate([n, n, m, n, values], STATIC) => wrong("accelerations a", n, m),
            evaluate([n, n, n, m, values], STATIC) => wrong("residual r", n, m),
        }
    }
    refused! {
        evaluate([n, n, n, n, values - 1], STATIC) => wrong("tangent S", values, values - 1),
        evaluate([n, n, 0, n, values], STATIC) => wrong("accelerations a", n, 0),
    }
}

#[test]
fn a_joint_that_ends_where_it_begins() {
    let mut b = ModelBuilder::new();
    let node = b.node("node", [0.0; 3]).unwrap();
    let seat = b.offset("seat", node, [1.0, 0.0, 0.0]).unwrap();
    for (name, parent, at) in [("A", node, "node"), ("B", seat, "seat")] {
        let joint = Revolute::new([0.0, 0.0, 1.0]).unwrap();
        let joint = b.attach(name, parent, joint).unwrap();
        refused! {
            b.close(joint.frame, parent) => format!(
                "joint {name}: its child {at} is the frame that it is attached to; a joint goes from one \
                 frame to another one"
            ),
        }
    }
    // To the frame that carries its own: nothing can move.
    let joint = Revolute::new([0.0, 0.0, 1.0]).unwrap();
    let joint = b.attach("C", seat, joint).unwrap();
    b.close(joint.frame, node).unwrap();
}

/// A function without a value.
#[derive(Debug)]
struct Nothing;

impl TimeFunction for Nothing {
    fn at(&self, _: f64, _: &[f64]) -> [f64; 3] {
        [f64::NAN; 3]
    }
}

#[test]
fn a_prescribed_motion_without_a_value_is_named() {
    let mut b = ModelBuilder::new();
    let a = b.node("a", [0.0; 3]).unwrap();
    mass(&mut b, a);
    b.support(a, &Dof::ALL[1..]);
    b.prescribe(a, Dof::X, Nothing);
    let mut context = Context::new(b.build().unwrap());
    let at = Point::statics(0.0, &[0.0]);
    let error = context.configure(at).unwrap_err();
    let named =
        "the prescribed motion of node a, displacement along e1 gives a value that is not finite";
    assert!(error.to_string().starts_with(named), "{error}");
}

/// x = √q has no derivative at zero.
#[derive(Clone, Copy)]
struct Roots;

impl Map<2, 2> for Roots {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 2>) -> SVector<S, 2> {
        q.map(|q| q.sqrt())
    }
}

#[test]
fn velocities_that_have_no_value() {
    let (mut b, lengths) = (ModelBuilder::new(), [Quantity::Length; 2]);
    let q = b.coordinates("q", &lengths).unwrap();
    let x = b
        .mapped_coordinates("x", &lengths, Roots.boxed(), &[q])
        .unwrap();
    b.element("idle", Idle(2), &[x]).unwrap();
    let mut context = Context::new(b.build().unwrap());
    let (rates, mut v) = ([(x, 0, 1.0), (x, 1, 1.0)], [0.0; 2]);
    let error = context.fit_coordinate_rates(&[0.0; 2], &mut v, &rates, &[]);
    let error = error.unwrap_err().to_string();
    assert!(error.starts_with("the velocity of node x"), "{error}");
}
