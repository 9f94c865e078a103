//! The slide against exact motions along a straight line and around a circle.

use crate::support::dynamics::*;
use crate::support::landing::{self, G, MASS};
use crate::support::prelude::*;
use nalgebra::Unit;

const RADIUS: f64 = 1.5;
const FRAC_PI_9: f64 = PI / 9.0;
const START: f64 = 2.0 * FRAC_PI_9;

/// A heavy point mass that slides along beam elements all of whose nodes are held.
fn bead(
    b: &mut ModelBuilder,
    axis: &dyn ReferenceCurve,
    elements: usize,
    origin: f64,
) -> JointNodes {
    let ends =
        [("from", 0.0), ("to", 1.0)].map(|(name, u)| b.node(name, axis.at(u).0.into()).unwrap());
    let line = BeamLine {
        elements,
        order: 1,
        section: Section::diagonal(1.0, [1.0; 2], 1.0, [1.0; 2]).unwrap(),
    };
    let nodes = b.line("wire", axis, ends, &line).unwrap().nodes;
    for &node in &nodes {
        b.support(node, &Dof::ALL);
    }
    landing::bead(b, "bead", &nodes, origin)
}

/// Three metres with a slope of 3 in 5.
fn incline() -> StraightLine {
    StraightLine {
        from: Vector3::new(0.1, 0.2, 0.3),
        to: Vector3::new(0.1, 0.2, 0.3) + Vector3::new(0.0, 2.4, -1.8),
        second: None,
        twist: 0.0,
    }
}

#[test]
fn a_driven_slide_bears_weight_and_inertia_of_its_mass() {
    let along = Vector3::new(0.0, 0.8, -0.6);
    let mut b = ModelBuilder::new();
    let bead = bead(&mut b, &incline(), 7, 1.4);
    let drive = sine(1.1, 2.5, 0.0);
    b.prescribe_coordinate(bead.coordinates[0], 0, drive);
    // Something must be unknown.
    let free = b.node("free", [0.0; 3]).unwrap();
    heavy_body(&mut b, "free", free, 1.0, [0.0; 3]);
    let mut context = Context::new(b.build().unwrap());
    let mut changes = 0;
    let options = tight(Scheme::default(), 2.6, 0.013);
    observed(&mut context, [&[], &[]], &options, &mut |context, step| {
        let s = &step.progress.state;
        let at = point(s);
        let mut r = vec![0.0; s.q.len()];
        context.evaluate(at, Evaluation::residual(&mut r)).unwrap();
        let [way, rate, second] = drive.at(s.t, &[]);
        let found = context.node_state(bead.frame);
        let position = incline().from + along * (1.4 + way);
        assert!((found.position - position).norm() < 1e-13);
        assert!((found.velocity - along * rate).norm() < 1e-12);
        let exact = (along * second + Vector3::z() * G) * MASS;
        let [force, moment] = context.joint_force(bead.frame).unwrap();
        assert!((force - exact).norm() < 1e-11, "{force} {exact}");
        assert!(moment.norm() < 1e-12);
        changes += step.chart_changes;
    });
    // From 1.4 up to 2.5, down to 0.3 and back: two elements on, five back, three on.
    assert_eq!(changes, 10, "elements left behind");
}

/// A position on the circle, the angle from its lowest point.
fn at(angle: f64) -> Vector3<f64> {
    Vector3::new(angle.sin(), 0.0, 1.0 - angle.cos()) * RADIUS
}

/// A mass on 160° of a vertical circle, the lowest point in the middle; it starts 40° before that.
fn on_circle(elements: u32) -> (Context, JointNodes) {
    let half = 4.0 * FRAC_PI_9;
    let arc = CircularArc {
        from: at(-half),
        center: Vector3::new(0.0, 0.0, RADIUS),
        axis: Unit::new_normalize(Vector3::new(0.0, -1.0, 0.0)),
        angle: 2.0 * half,
        second: None,
    };
    assert!((arc.at(0.5).0 - at(0.0)).norm() < 1e-12);
    // 40° from the end: a quarter of the chain.
    let n = f64::from(elements);
    let chord = 2.0 * RADIUS * (half / n).sin();
    let mut b = ModelBuilder::new();
    let bead = bead(&mut b, &arc, elements as usize, chord * n / 4.0);
    let context = Context::new(b.build().unwrap());
    assert!((context.node(bead.frame).position() - at(-START)).norm() < 1e-12);
    (context, bead)
}

#[test]
fn a_mass_on_a_circle_of_wire_is_a_pendulum() {
    // The mass moves all the time: from rest, or where it turns, the slope of a chord in the place
    // of that of the circle would count more than its error in height, which falls with order 2.
    // The error of the steps falls with order 2 as well: they are quartered where elements are halved.
    let rate = 2.0;
    // Until it is as far beyond the lowest point, where all meshes have a node, by Newton's method.
    let ode = |_: f64, y: &Vector2<f64>| Vector2::new(y[1], -G / RADIUS * y[0].sin());
    let mut to = 0.6;
    for _ in 0..6 {
        let end = integrate_ode(&ode, Vector2::new(-START, rate), to, 4000);
        to -= (end[0] - START) / end[1];
    }
    let errors = [4, 8, 16].map(|elements| {
        let (mut context, bead) = on_circle(elements);
        let h = to * 1e-2 / f64::from(elements).powi(2);
        let options = tight(Scheme::default(), to, h);
        let v = [rate * RADIUS];
        let progress = observed(&mut context, [&[], &v], &options, &mut |_, _| ());
        configure(&mut context, &progress.state);
        (context.node_state(bead.frame).position - at(START)).norm()
    });
    assert_order("circle", &errors, 2.0, 0.15);
}
