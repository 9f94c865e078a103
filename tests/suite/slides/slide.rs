//! The slide against exact motions along a straight line and around a circle, and its end.

#![allow(non_snake_case, clippy::unwrap_used)]

use crate::support::dynamics::*;
use nalgebra::{Unit, Vector2, Vector3};
use pullback::elements::beam::{Interpolation, Section};
use pullback::elements::body::PointMass;
use pullback::elements::joint::JointNodes;
use pullback::elements::model::{
    BeamLine, CircularArc, Context, Dof, ModelBuilder, ReferenceCurve, StraightLine,
};
use pullback::elements::time::{Constant, TimeFunction};
use pullback::integrators::dynamics::{
    DynamicsError, Progress, Scheme, StepReport, integrate, start,
};
use pullback::integrators::statics::Cause;
use pullback::manifold::domain::DomainError;
use pullback::manifold::system::{Evaluation, System, SystemError};
use std::f64::consts::PI;
use std::ops::ControlFlow;

const G: f64 = 9.81;
const RADIUS: f64 = 1.5;
const FRAC_PI_9: f64 = PI / 9.0;
const START: f64 = 2.0 * FRAC_PI_9;

const MASS: f64 = 1.3;

/// A heavy point mass that slides along beam elements all of whose nodes are held.
fn wire(axis: &dyn ReferenceCurve, elements: usize, origin: f64) -> (Context, JointNodes) {
    let mut b = ModelBuilder::new();
    let bead = bead(&mut b, axis, elements, origin);
    (Context::new(b.build().unwrap()), bead)
}

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
    let bead = b
        .slide("bead", &nodes, origin, Interpolation::Total)
        .unwrap();
    let mass = PointMass::new(MASS).unwrap();
    let weight = mass.weight([0.0, 0.0, -G], Constant(1.0));
    b.element("mass", mass, &[bead.frame]).unwrap();
    b.element("weight", weight, &[bead.frame]).unwrap();
    bead
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
fn a_mass_on_an_incline_accelerates_uniformly_over_several_elements() {
    let along = Vector3::new(0.0, 0.8, -0.6);
    for scheme in second_order() {
        let (mut context, bead) = wire(&incline(), 7, 0.2);
        let v = [0.4];
        // 0.4 t + ½ · 0.6 g t² = 1.87 at the end: more than four elements.
        let mut changes = 0;
        let options = tight(scheme, 0.7, 0.007);
        observed(&mut context, [&[], &v], &options, &mut |context, step| {
            let t = step.progress.state.t;
            let way = [0.4 * t + 0.3 * G * t * t, 0.4 + 0.6 * G * t];
            let found = context.coordinate(bead.coordinates[0], 0).unwrap();
            assert!((found[0] - way[0]).abs() < 1e-12, "{found:?} at {t}");
            assert!((found[1] - way[1]).abs() < 1e-11, "{found:?} at {t}");
            let s = context.node_state(bead.frame);
            let position = incline().from + along * (0.2 + way[0]);
            assert!((s.position - position).norm() < 1e-12);
            assert!((s.velocity - along * way[1]).norm() < 1e-11);
            assert!((s.acceleration - along * (0.6 * G)).norm() < 1e-10);
            changes += step.chart_changes;
        });
        assert_eq!(changes, 4, "elements left behind");
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

#[test]
fn beyond_the_end_of_the_chain_is_an_error_with_a_name() {
    let (mut context, _) = wire(&incline(), 7, 2.5);
    let mut progress = Progress::new(start(&context, 0.0, &[], &[]).unwrap());
    let options = tight(Scheme::default(), 1.0, 0.01);
    let proceed = &mut |_: &mut Context, _: &StepReport<'_>| ControlFlow::Continue(());
    let error = integrate(&mut context, &mut progress, &options, proceed).unwrap_err();
    let DynamicsError::Step(failed) = error else {
        panic!("{error}");
    };
    let Cause::System(SystemError::Domain { what, why }) = &failed.cause else {
        panic!("{failed}");
    };
    assert_eq!(what, "joint at node bead");
    assert!(matches!(why, DomainError::Beyond { margin, .. } if *margin <= 0.0));
    // The run stands at the last position on the chain: half a metre at 0.6 g takes 0.4122 s.
    let at_end = (2.0 * 0.5 / (0.6 * G)).sqrt();
    assert!(
        (progress.state.t - at_end).abs() < 1e-4,
        "{}",
        progress.state.t
    );
    assert!((progress.state.q[0] - 0.5).abs() < 1e-3);
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
    let (context, bead) = wire(&arc, elements as usize, chord * n / 4.0);
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
    for slope in slopes(&errors) {
        assert!((slope - 2.0).abs() < 0.15, "{errors:?}");
    }
}

#[test]
fn the_energy_of_a_mass_on_a_circle_of_wire_is_kept() {
    // On a chord the acceleration is uniform, which the trapezoidal rule integrates exactly. A mass
    // that went on beyond the end of an element would lose or gain height of order 1 in h.
    let to = 0.56;
    for n in [250.0, 1000.0, 4000.0] {
        let (mut context, bead) = on_circle(32);
        let mut energies = Vec::new();
        let options = tight(Scheme::default(), to, to / n);
        let run = observed(&mut context, [&[], &[3.0]], &options, &mut |context, _| {
            let s = context.node_state(bead.frame);
            energies.push(0.5 * s.velocity.norm_squared() + G * s.position.z);
        });
        let left = run.summary.chart_changes;
        let change = |e: &f64| (e - energies[0]).abs();
        let worst = energies.iter().map(change).fold(0.0, f64::max);
        assert!(left > 5, "{left} elements were left");
        assert!(worst < 1e-10 * energies[0].abs(), "{n}: {worst:e}");
    }
}
