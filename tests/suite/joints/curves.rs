//! Points on curves and surfaces in motion, against closed forms.

#![allow(clippy::unwrap_used)]

use crate::support::dynamics::{assert_slopes, body, configure, grounded, revolute, tight};
use nalgebra::Matrix3;
use pullback::elements::joint::{Curve, JointNodes, OnCurve, OnSurface, Spline, Surface};
use pullback::elements::model::NodeState;
use pullback::integrators::dynamics::{Progress, StepReport, integrate};
use pullback::manifold::system::System;
use pullback::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::ControlFlow;

const G: f64 = 9.81;

fn trapezoidal() -> Scheme {
    Scheme::newmark(0.25, 0.5).unwrap()
}

/// A body whose rotation does not couple with its motion, on whatever `hang` makes on the ground.
fn bead(hang: impl Fn(&mut ModelBuilder, NodeId) -> JointNodes) -> (Context, JointNodes) {
    let (mut b, ground) = grounded();
    let made = hang(&mut b, ground);
    let sphere = RigidBody::new(2.0, Matrix3::identity() * 0.03, Vector3::zeros()).unwrap();
    body(&mut b, "bead", made.frame, sphere);
    (Context::new(b.build().unwrap()), made)
}

/// The state after `to`, the first released coordinates starting with these values and rates.
fn moved(
    (model, made): &mut (Context, JointNodes),
    first: &[[f64; 2]],
    to: f64,
    steps: usize,
) -> (NodeState, Vec<[f64; 2]>) {
    let n = model.pattern().dim();
    let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
    for (&node, &[value, rate]) in made.coordinates.iter().zip(first) {
        assert!(model.set(&mut q, node, 0, value) && model.set(&mut v, node, 0, rate));
    }
    let mut progress = Progress::new(start(model, 0.0, &q, &v).unwrap());
    let options = tight(trapezoidal(), to, to / steps as f64);
    let go_on = &mut |_: &mut Context, _: &StepReport<'_>| ControlFlow::Continue(());
    integrate(model, &mut progress, &options, go_on).unwrap();
    configure(model, &progress.state);
    let own = made.coordinates.iter().take(first.len());
    let own = own.map(|&node| model.coordinate(node, 0).unwrap());
    (model.node_state(made.frame), own.collect())
}

/// The cycloid x = a (s + sin s), z = a (1 − cos s).
#[derive(Clone)]
struct Cycloid(f64);

impl Curve for Cycloid {
    fn at<S: Scalar>(&self, s: S) -> Vector3<S> {
        Vector3::new((s + s.sin()) * self.0, S::zero(), (-s.cos() + 1.0) * self.0)
    }
}

#[test]
fn a_bead_on_a_cycloid_takes_the_same_time_from_any_height() {
    let a = 0.5;
    // 4 a sin(s/2) swings with ω = ½ √(g/a).
    let quarter = PI * (a / G).sqrt();
    for amplitude in [0.1, 1.0, 2.9] {
        let errors: Vec<Vec<f64>> = [100, 200, 400]
            .map(|steps| {
                let mut made =
                    bead(|b, on| b.attach_free("bead", on, OnCurve::new(Cycloid(a))).unwrap());
                let (_, own) = moved(&mut made, &[[amplitude, 0.0]], quarter, steps);
                vec![own[0][0].abs() / amplitude]
            })
            .into();
        let what = format!("from {amplitude}");
        assert_slopes(&what, &["position at the quarter"], &errors, 2.0, 0.1);
        assert!(errors[2][0] < 1e-4, "{what}: {errors:?}");
    }
}

/// The helix of radius 0.7 and rise 0.2 per radian, about e3.
#[derive(Clone)]
struct Helix;

impl Curve for Helix {
    fn at<S: Scalar>(&self, s: S) -> Vector3<S> {
        Vector3::new(s.cos() * 0.7, s.sin() * 0.7, s * 0.2)
    }
}

#[test]
fn a_bead_runs_down_a_helix_with_constant_acceleration() {
    let mut made = bead(|b, on| b.attach_free("bead", on, OnCurve::new(Helix)).unwrap());
    let (state, own) = moved(&mut made, &[[0.0, 1.0]], 2.0, 200);
    // (r² + c²) s̈ = −g c: the trapezoidal rule follows a parabola exactly.
    let s_ddot = -G * 0.2 / (0.7 * 0.7 + 0.2 * 0.2);
    let s = 2.0 + 0.5 * s_ddot * 4.0;
    assert!(s < -4.0, "it makes turns: {s}");
    assert!((own[0][0] - s).abs() < 1e-10);
    assert!((own[0][1] - (1.0 + 2.0 * s_ddot)).abs() < 1e-10);
    let position = Vector3::new(0.7 * s.cos(), 0.7 * s.sin(), 0.2 * s);
    assert!((state.position - position).norm() < 1e-10);
}

/// The parabola z = ½ k x².
#[derive(Clone)]
struct Parabola(f64);

impl Curve for Parabola {
    fn at<S: Scalar>(&self, x: S) -> Vector3<S> {
        Vector3::new(x, S::zero(), x * x * (0.5 * self.0))
    }
}

#[test]
fn a_bead_swings_on_a_parabola_in_the_time_of_an_elliptic_integral() {
    let (k, amplitude) = (1.5, 0.9);
    // ½ (1 + k² x²) ẋ² = ½ g k (A² − x²) gives for the quarter of the period, with x = A sin φ,
    // (g k)^−½ ∫ (1 + k² A² sin² φ)^½ dφ over [0, π/2]; sums of equal steps converge at once.
    let n = 64;
    let root = |j: usize| {
        let sine = (FRAC_PI_2 * (j as f64 + 0.5) / n as f64).sin();
        (1.0 + (k * amplitude * sine).powi(2)).sqrt()
    };
    let mean = (0..n).map(root).sum::<f64>() / n as f64;
    let quarter = FRAC_PI_2 * mean / (G * k).sqrt();
    let errors: Vec<Vec<f64>> = [100, 200, 400]
        .map(|steps| {
            let mut made = bead(|b, on| {
                b.attach_free("bead", on, OnCurve::new(Parabola(k)))
                    .unwrap()
            });
            let (_, own) = moved(&mut made, &[[amplitude, 0.0]], quarter, steps);
            // At the bottom all energy is kinetic.
            let fastest = amplitude * (G * k).sqrt();
            vec![own[0][0].abs(), (own[0][1] + fastest).abs()]
        })
        .into();
    assert_slopes("parabola", &["position", "rate"], &errors, 2.0, 0.1);
    assert!(errors[2].iter().all(|e| *e < 1e-4), "{errors:?}");
}

#[test]
fn a_bead_sets_out_from_the_end_of_its_curve() {
    let line = Spline::through(&[[0.0; 3], [2.0, 0.0, 0.0]], false, 0.0).unwrap();
    let mut made = bead(|b, on| {
        b.attach_free("bead", on, OnCurve::new(line.clone()))
            .unwrap()
    });
    let (state, _) = moved(&mut made, &[[0.0, 1.5]], 0.8, 40);
    assert!((state.position - Vector3::new(1.2, 0.0, 0.0)).norm() < 1e-10);
}

/// The line through the parent along e1.
#[derive(Clone)]
struct Wire;

impl Curve for Wire {
    fn at<S: Scalar>(&self, s: S) -> Vector3<S> {
        Vector3::new(s + 0.5, S::zero(), S::zero())
    }
}

#[test]
fn a_bead_is_flung_along_a_wire_that_turns() {
    let (omega, to) = (3.0, 0.7);
    let errors: Vec<Vec<f64>> = [100, 200, 400]
        .map(|steps| {
            let mut made = bead(|b, on| {
                let hub = revolute(b, "hub", on, [0.0, 0.0, 1.0]);
                b.prescribe_coordinate(hub.coordinates[0], 0, Proportional(omega));
                b.attach_free("bead", hub.frame, OnCurve::new(Wire))
                    .unwrap()
            });
            let (state, _) = moved(&mut made, &[[0.0, 0.0]], to, steps);
            // r̈ = Ω² r.
            let r = 0.5 * (omega * to).cosh();
            let position = Vector3::new((omega * to).cos(), (omega * to).sin(), 0.0) * r;
            let rate = 0.5 * omega * (omega * to).sinh();
            let speed = rate.hypot(omega * r);
            vec![
                (state.position - position).norm(),
                (state.velocity.norm() - speed).abs(),
            ]
        })
        .into();
    assert_slopes("wire", &["position", "speed"], &errors, 2.0, 0.1);
    assert!(errors[2].iter().all(|e| *e < 1e-3), "{errors:?}");
}

/// The sphere of this radius about the parent, without its poles on e2: angle u about e2 and
/// latitude v, from the lowest point.
#[derive(Clone)]
struct Sphere(f64);

impl Surface for Sphere {
    fn at<S: Scalar>(&self, u: S, v: S) -> Vector3<S> {
        let across = v.cos() * self.0;
        Vector3::new(u.sin() * across, v.sin() * self.0, -u.cos() * across)
    }

    fn margin(&self, _u: f64, v: f64) -> f64 {
        FRAC_PI_2 - v.abs()
    }
}

#[test]
fn a_point_on_a_sphere_is_a_spherical_pendulum() {
    let (length, theta) = (0.8, PI / 5.0);
    // On a cone of half angle θ it goes round with ω² = g/(l cos θ).
    let omega = (G / (length * theta.cos())).sqrt();
    let errors: Vec<Vec<f64>> = [200, 400, 800]
        .map(|steps| {
            let mut made = bead(|b, on| {
                b.attach_free("bead", on, OnSurface::new(Sphere(length)))
                    .unwrap()
            });
            // At v = 0 the point moves along e2 with l v̇.
            let first = [[theta, 0.0], [0.0, omega * theta.sin()]];
            let (state, _) = moved(&mut made, &first, 2.0, steps);
            let (s, c) = (omega * 2.0).sin_cos();
            let radius = length * theta.sin();
            let position = Vector3::new(radius * c, radius * s, -length * theta.cos());
            let velocity = Vector3::new(-s, c, 0.0) * (radius * omega);
            vec![
                (state.position - position).norm(),
                (state.velocity - velocity).norm(),
            ]
        })
        .into();
    assert_slopes("sphere", &["position", "velocity"], &errors, 2.0, 0.1);
    assert!(errors[2].iter().all(|e| *e < 1e-3), "{errors:?}");
}

#[test]
fn a_point_at_the_edge_of_a_surface_ends_the_motion_by_name() {
    let mut made = bead(|b, on| {
        b.attach_free("bead", on, OnSurface::new(Sphere(1.0)))
            .unwrap()
    });
    let n = made.0.pattern().dim();
    let (q, mut v) = (vec![0.0; n], vec![0.0; n]);
    // Fast enough along e2 to come over the pole.
    assert!(made.0.set(&mut v, made.1.coordinates[1], 0, 9.0));
    let mut progress = Progress::new(start(&made.0, 0.0, &q, &v).unwrap());
    let go_on = &mut |_: &mut Context, _: &StepReport<'_>| ControlFlow::Continue(());
    let options = tight(trapezoidal(), 2.0, 0.01);
    let error = integrate(&mut made.0, &mut progress, &options, go_on).unwrap_err();
    let said = error.to_string();
    assert!(
        said.contains("joint at node bead left its surface over an edge"),
        "{said}"
    );
    let reached = made.0.node_state(made.1.frame).position;
    assert!(reached.y > 0.9, "{reached}");
}
