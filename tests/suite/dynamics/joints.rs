//! Every joint against the same system described in another way: closed forms, ordinary
//! differential equations of minimal coordinates integrated here, a stiff beam.

#![allow(non_snake_case, clippy::unwrap_used)]

use crate::support::beams::beam;
use crate::support::dynamics::*;
use nalgebra::{Matrix2, Matrix3, SVector, Vector2, Vector3};
use pullback::elements::beam::Section;
use pullback::elements::body::{PointMass, RigidBody};
use pullback::elements::joint::{JointNodes, Spherical};
use pullback::elements::load::CoordinateForce;
use pullback::elements::model::{Context, ModelBuilder, NodeId, NodeState};
use pullback::elements::spring::{CoordinateLaw, CoordinateSpring};
use pullback::elements::time::{Constant, TimeFunction};
use pullback::integrators::dynamics::{Progress, Scheme};
use pullback::manifold::so3;
use pullback::manifold::system::System;

const G: f64 = 9.81;

/// Zeros with some coordinates set.
fn values(context: &Context, set: &[(NodeId, usize, f64)]) -> Vec<f64> {
    let mut x = vec![0.0; context.pattern().dim()];
    for &(node, k, value) in set {
        assert!(context.set(&mut x, node, k, value));
    }
    x
}

/// Values and rates of coordinate nodes at the end of a run.
fn ending(context: &mut Context, progress: &Progress, nodes: &[NodeId]) -> Vec<f64> {
    configure(context, &progress.state);
    let both = |&n: &NodeId| context.coordinate(n, 0).unwrap();
    nodes.iter().flat_map(both).collect()
}

/// Absolute differences, for slopes.
fn gaps(found: &[f64], exact: &[f64]) -> Vec<f64> {
    assert_eq!(found.len(), exact.len());
    found
        .iter()
        .zip(exact)
        .map(|(a, b)| (a - b).abs())
        .collect()
}

// Offset ---------------------------------------------------------------------------------------

/// Two bodies a metre apart, turning and falling, joined by a rigid link or by a massless beam of
/// the given stiffness; the motion of both.
fn linked(stiffness: Option<f64>) -> Vec<NodeState> {
    let mut b = ModelBuilder::new();
    let first = b.node("first", [0.0; 3]).unwrap();
    heavy_body(&mut b, "first", first, 1.0, [0.1, 0.2, 0.0]);
    let position = [1.0, 0.3, -0.2];
    let second = if let Some(s) = stiffness {
        let second = b.node("second", position).unwrap();
        beam(
            &mut b,
            "link",
            [first, second],
            1,
            Section::diagonal(s, [s; 2], s, [s; 2]).unwrap(),
        );
        second
    } else {
        b.offset("second", first, position).unwrap()
    };
    heavy_body(&mut b, "second", second, 0.5, [0.0, 0.1, 0.1]);
    let mut context = Context::new(b.build().unwrap());
    let q = values(&context, &[]);
    let v = turning(&mut context, &q, Vector3::new(0.4, -0.3, 1.0));
    let options = tight(Scheme::chung_hulbert(0.5).unwrap(), 1.0, 1e-3);
    history(&mut context, &[first, second], [&q, &v], &options, 10).0
}

#[test]
fn an_offset_is_the_limit_of_a_stiff_beam() {
    let rigid = linked(None);
    let gaps = [1e2, 1e3, 1e4].map(|s| distances(&linked(Some(s)), &rigid));
    // Strains are forces over stiffness, s. They vibrate with frequencies like √s: positions differ like
    // 1/s, velocities like 1/√s, accelerations do not tend to those of the rigid link at all.
    for k in 0..2 {
        assert!(gaps[1][k] < gaps[0][k] / 7.0, "{gaps:?}");
        assert!(gaps[2][k] < gaps[1][k] / 7.0, "{gaps:?}");
    }
    for k in 2..4 {
        assert!(gaps[2][k] < gaps[0][k] / 7.0, "{gaps:?}");
    }
}

// Revolute -------------------------------------------------------------------------------------

#[test]
fn a_pendulum_on_a_skew_axis() {
    // J θ̈ = e·(R(θe)c × m g) about a fixed axis e that is neither horizontal nor vertical.
    let axis = Vector3::new(1.0, 0.5, 0.3);
    let e = axis.normalize();
    let (m, c) = (1.7, Vector3::new(0.4, -0.2, 0.6));
    let J = Matrix3::new(0.3, 0.02, 0.03, 0.02, 0.4, -0.04, 0.03, -0.04, 0.5);
    let about = e.dot(&(J * e)) + m * e.cross(&c).norm_squared();
    let ode = move |_: f64, y: &Vector2<f64>| {
        let arm = so3::rotation(&(e * y[0])) * c;
        let torque = e.dot(&arm.cross(&Vector3::new(0.0, 0.0, -m * G)));
        Vector2::new(y[1], torque / about)
    };
    let to = 2.0;
    let exact = integrate_ode(&ode, Vector2::new(0.3, 2.0), to, 4000);
    let errors = [200, 400, 800].map(|n| {
        let (mut b, ground) = grounded();
        let hinge = revolute(&mut b, "hinge", ground, axis.into());
        body(&mut b, "bar", hinge.frame, RigidBody::new(m, J, c).unwrap());
        let mut context = Context::new(b.build().unwrap());
        let (q, v) = (
            values(&context, &[(hinge.coordinates[0], 0, 0.3)]),
            values(&context, &[(hinge.coordinates[0], 0, 2.0)]),
        );
        let options = tight(Scheme::default(), to, to / n as f64);
        let progress = observed(&mut context, [&q, &v], &options, &mut |_, _| ());
        gaps(
            &ending(&mut context, &progress, &[hinge.coordinates[0]]),
            exact.as_slice(),
        )
    });
    assert_slopes("pendulum", &["angle", "rate"], &errors, 2.0, 0.1);
    assert!(errors[2][0] < 1e-4, "{errors:?}");
}

/// Double pendulum of slender bars (lengths l, masses m), absolute angles from the vertical.
fn double_pendulum(l: [f64; 2], m: [f64; 2], y: &SVector<f64, 4>) -> SVector<f64, 4> {
    let (s, c) = (y[0] - y[1]).sin_cos();
    let couple = 0.5 * m[1] * l[0] * l[1];
    let M = Matrix2::new(
        (m[0] / 3.0 + m[1]) * l[0] * l[0],
        couple * c,
        couple * c,
        m[1] * l[1] * l[1] / 3.0,
    );
    let f = Vector2::new(
        -couple * s * y[3] * y[3] - (0.5 * m[0] + m[1]) * G * l[0] * y[0].sin(),
        couple * s * y[2] * y[2] - 0.5 * m[1] * G * l[1] * y[1].sin(),
    );
    let a = M.lu().solve(&f).unwrap();
    SVector::<f64, 4>::new(y[2], y[3], a[0], a[1])
}

#[test]
fn a_double_pendulum_of_bars() {
    let (l, m) = ([1.0, 0.7], [1.5, 0.8]);
    let to = 1.5;
    let start = SVector::<f64, 4>::new(1.2, 2.0, 0.5, -1.0);
    let ode = |_: f64, y: &SVector<f64, 4>| double_pendulum(l, m, y);
    let exact = integrate_ode(&ode, start, to, 6000);
    // Angles of the joints, one relative to the other: (angle, rate) each.
    let exact = [exact[0], exact[2], exact[1] - exact[0], exact[3] - exact[2]];
    let axis = [1.0, 1.0, 0.0];
    let e = Vector3::from(axis).normalize();
    let bar = |k: usize| {
        let I = m[k] * l[k] * l[k] / 12.0;
        let J = Matrix3::from_diagonal(&Vector3::new(I, I, 0.0));
        RigidBody::new(m[k], J, Vector3::new(0.0, 0.0, -0.5 * l[k])).unwrap()
    };
    let errors = [400, 800, 1600].map(|n| {
        let (mut b, ground) = grounded();
        let first = revolute(&mut b, "first", ground, axis);
        body(&mut b, "upper", first.frame, bar(0));
        let end = b.offset("end", first.frame, [0.0, 0.0, -l[0]]).unwrap();
        let second = revolute(&mut b, "second", end, axis);
        body(&mut b, "lower", second.frame, bar(1));
        let tip = b
            .offset("tip", second.frame, [0.0, 0.0, -l[0] - l[1]])
            .unwrap();
        b.element("fly", PointMass::new(1e-12).unwrap(), &[tip])
            .unwrap();
        let mut context = Context::new(b.build().unwrap());
        let (u, w) = (first.coordinates[0], second.coordinates[0]);
        let q = values(&context, &[(u, 0, start[0]), (w, 0, start[1] - start[0])]);
        let v = values(&context, &[(u, 0, start[2]), (w, 0, start[3] - start[2])]);
        let options = tight(Scheme::default(), to, to / n as f64);
        let progress = observed(&mut context, [&q, &v], &options, &mut |_, _| ());
        let found = ending(&mut context, &progress, &[u, w]);
        // The tip is where the angles say.
        let hang = |angle: f64, l: f64| so3::rotation(&(e * angle)) * Vector3::new(0.0, 0.0, -l);
        let position = hang(found[0], l[0]) + hang(found[0] + found[2], l[1]);
        assert!((context.node_state(tip).position - position).norm() < 1e-13);
        gaps(&found, &exact)
    });
    let names = ["first angle", "its rate", "second angle", "its rate"];
    assert_slopes("double pendulum", &names, &errors, 2.0, 0.1);
    assert!(errors[2][0] < 1e-4, "{errors:?}");
}

// Spherical ------------------------------------------------------------------------------------

#[test]
fn a_spherical_pendulum() {
    // A point mass m at u l and a wheel of inertia j in all directions at the joint: without spin
    // about u it is the spherical pendulum with (m l² + j) in the place of m l².
    let (m, l, j) = (1.3, 0.8, 0.05);
    let k = m * G * l / (m * l * l + j);
    let ode = move |_: f64, y: &SVector<f64, 6>| {
        let (u, w) = (y.fixed_rows::<3>(0), y.fixed_rows::<3>(3));
        let down = Vector3::new(0.0, 0.0, -k);
        let a = down - u * u.dot(&down) - u * w.norm_squared();
        SVector::<f64, 6>::from_fn(|i, _| if i < 3 { y[3 + i] } else { a[i - 3] })
    };
    let u = Vector3::new(0.6, 0.0, -0.8);
    let omega = u.cross(&Vector3::new(0.5, 3.0, 0.375));
    let w = omega.cross(&u);
    let to = 2.0;
    let start = SVector::<f64, 6>::new(u.x, u.y, u.z, w.x, w.y, w.z);
    let exact = integrate_ode(&ode, start, to, 8000);
    let errors = [200, 400, 800].map(|n| {
        let (mut b, ground) = grounded();
        let ball = b.attach_free("ball", ground, Spherical).unwrap();
        let wheel = RigidBody::new(0.0, Matrix3::identity() * j, Vector3::zeros()).unwrap();
        b.element("wheel", wheel, &[ball.frame]).unwrap();
        let end = b.offset("end", ball.frame, (u * l).into()).unwrap();
        let point = PointMass::new(m).unwrap();
        let weight = point.weight([0.0, 0.0, -G], Constant(1.0));
        b.element("mass", point, &[end]).unwrap();
        b.element("weight", weight, &[end]).unwrap();
        let mut context = Context::new(b.build().unwrap());
        let q = values(&context, &[]);
        let v = turning(&mut context, &q, omega);
        let options = tight(Scheme::default(), to, to / n as f64);
        let progress = observed(&mut context, [&q, &v], &options, &mut |_, _| ());
        configure(&mut context, &progress.state);
        let s = context.node_state(end);
        let (position, rate) = (exact.fixed_rows::<3>(0) * l, exact.fixed_rows::<3>(3) * l);
        vec![(s.position - position).norm(), (s.velocity - rate).norm()]
    });
    assert_slopes(
        "spherical pendulum",
        &["position", "velocity"],
        &errors,
        2.0,
        0.1,
    );
    assert!(errors[2][0] < 1e-3, "{errors:?}");
}

// What acts on a released angle ----------------------------------------------------------------

/// A body on a vertical axis through the origin, so that its weight does nothing, and its moment of
/// inertia about that axis.
fn turntable(more: impl FnOnce(&mut ModelBuilder, JointNodes)) -> (Context, JointNodes, f64) {
    let (mut b, ground) = grounded();
    let hinge = revolute(&mut b, "hinge", ground, [0.0, 0.0, 2.0]);
    heavy_body(&mut b, "table", hinge.frame, 2.0, [0.3, -0.4, 0.2]);
    more(&mut b, hinge.clone());
    // 0.5 kg m² per kg about the centre of mass, half a metre from the axis.
    (Context::new(b.build().unwrap()), hinge, 2.0 * (0.5 + 0.25))
}

#[test]
fn a_constant_torque_gives_a_constant_acceleration() {
    let torque = 3.0;
    for scheme in second_order() {
        let (mut context, hinge, J) = turntable(|b, hinge| {
            let motor = CoordinateForce::new(Constant(torque));
            b.element("motor", motor, &[hinge.coordinates[0]]).unwrap();
        });
        let to = 4.0;
        let progress = observed(
            &mut context,
            [&[], &[]],
            &tight(scheme, to, 0.05),
            &mut |_, _| (),
        );
        let found = ending(&mut context, &progress, &[hinge.coordinates[0]]);
        // A parabola is exact in every scheme of the family; 16 rad are two turns and a half.
        let exact = [0.5 * torque / J * to * to, torque / J * to];
        for gap in gaps(&found, &exact) {
            assert!(gap < 1e-10, "{}: {found:?} for {exact:?}", scheme.name);
        }
    }
}

#[test]
fn a_spring_and_a_damper_on_the_angle_make_an_oscillator() {
    let (k, c, x0) = (20.0, 0.9, 0.4);
    let (to, start) = (2.0, 1.5);
    for scheme in second_order() {
        let mut exact = Vec::new();
        let errors = [200, 400, 800].map(|n| {
            let (mut context, hinge, J) = turntable(|b, hinge| {
                let law = CoordinateLaw { k, k3: 0.0, c, x0 };
                let spring = CoordinateSpring::new(law).unwrap();
                b.element("spring", spring, &[hinge.coordinates[0]])
                    .unwrap();
            });
            // θ = x₀ + (θ₀ − x₀) e^{−δt} (cos ωt + δ/ω sin ωt), δ = c/2J, ω² = k/J − δ².
            let delta = 0.5 * c / J;
            let omega = (k / J - delta * delta).sqrt();
            let (s, cos) = (omega * to).sin_cos();
            let amplitude = (start - x0) * (-delta * to).exp();
            exact = vec![
                x0 + amplitude * (cos + delta / omega * s),
                -amplitude * (omega + delta * delta / omega) * s,
            ];
            let q = values(&context, &[(hinge.coordinates[0], 0, start)]);
            let options = tight(scheme, to, to / n as f64);
            let progress = observed(&mut context, [&q, &[]], &options, &mut |_, _| ());
            gaps(
                &ending(&mut context, &progress, &[hinge.coordinates[0]]),
                &exact,
            )
        });
        assert_slopes(scheme.name, &["angle", "rate"], &errors, 2.0, 0.1);
        assert!(errors[2][0] < 1e-4, "{errors:?}");
    }
}

#[test]
fn a_prescribed_angle_is_followed_exactly() {
    // Ten radians to and fro; a second, free body turns on the first.
    let drive = sine(10.0, 1.3, 0.3);
    let (mut b, ground) = grounded();
    let axis = Vector3::new(0.3, -0.5, 1.0);
    let e = axis.normalize();
    let hinge = revolute(&mut b, "hinge", ground, axis.into());
    b.prescribe_coordinate(hinge.coordinates[0], 0, drive);
    heavy_body(&mut b, "driven", hinge.frame, 2.0, [0.3, 0.0, 0.0]);
    let X = Vector3::new(0.7, 0.2, -0.4);
    let end = b.offset("end", hinge.frame, X.into()).unwrap();
    let free = revolute(&mut b, "free", end, [1.0, 0.0, 0.0]);
    heavy_body(&mut b, "free", free.frame, 0.4, [0.0, 0.2, 0.1]);
    let mut context = Context::new(b.build().unwrap());
    let mut turned = 0.0_f64;
    let options = tight(Scheme::chung_hulbert(0.8).unwrap(), 3.0, 0.01);
    let progress = observed(&mut context, [&[], &[]], &options, &mut |context, step| {
        let [angle, rate, second] = drive.at(step.progress.state.t, &[]);
        let R = so3::rotation(&(e * angle));
        let x = R * X;
        let (along, across) = (e.cross(&x), e.cross(&e.cross(&x)));
        let (frame, end) = (context.node_state(hinge.frame), context.node_state(end));
        assert!((frame.R - R).amax() < 1e-13);
        assert!((frame.omega - e * rate).norm() < 1e-12);
        assert!((end.position - x).norm() < 1e-13);
        assert!((end.velocity - along * rate).norm() < 1e-12);
        let acceleration = along * second + across * (rate * rate);
        assert!((end.acceleration - acceleration).norm() < 1e-10);
        turned = turned.max(context.coordinate(free.coordinates[0], 0).unwrap()[0].abs());
    });
    assert!(turned > 0.1, "the second body is to move");
    // Poses have no charts, whatever their angles.
    assert_eq!(progress.summary.chart_changes, 0);
}
