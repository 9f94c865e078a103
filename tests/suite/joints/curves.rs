//! Points on curves and surfaces in motion, against closed forms.

use crate::support::dynamics::{assert_slopes, body, configure, grounded, observed, tight};
use crate::support::prelude::*;
use crate::support::program::assert_says;

const G: f64 = 9.81;

/// A body whose rotation does not couple with its motion, on whatever `hang` makes on the ground.
fn bead(hang: impl Fn(&mut ModelBuilder, NodeId) -> JointNodes) -> (Context, JointNodes) {
    let (mut b, ground) = grounded();
    let made = hang(&mut b, ground);
    let sphere = RigidBody::new(2.0, Matrix3::identity() * 0.03, Vector3::zeros()).unwrap();
    body(&mut b, "bead", made.frame, sphere);
    (Context::new(b.build().unwrap()), made)
}

/// The state after `to`, the parameter starting with this value and rate, and both at the end.
fn moved(
    (model, made): &mut (Context, JointNodes),
    first: [f64; 2],
    to: f64,
    steps: usize,
) -> (NodeState, [f64; 2]) {
    let n = model.pattern().dim();
    let start = first.map(|x| {
        let mut all = vec![0.0; n];
        assert!(model.set(&mut all, made.coordinates[0], 0, x));
        all
    });
    let options = tight(Scheme::default(), to, to / steps as f64);
    let run = observed(model, [&start[0], &start[1]], &options, &mut |_, _| ());
    configure(model, &run.state);
    let own = model.coordinate(made.coordinates[0], 0).unwrap();
    (model.node_state(made.frame), own)
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
                let (_, own) = moved(&mut made, [amplitude, 0.0], quarter, steps);
                vec![own[0].abs() / amplitude]
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
    let (state, own) = moved(&mut made, [0.0, 1.0], 2.0, 200);
    // (r² + c²) s̈ = −g c: the trapezoidal rule follows a parabola exactly.
    let s_ddot = -G * 0.2 / (0.7 * 0.7 + 0.2 * 0.2);
    let s = 2.0 + 0.5 * s_ddot * 4.0;
    assert!(s < -4.0, "it makes turns: {s}");
    assert!((own[0] - s).abs() < 1e-10);
    assert!((own[1] - (1.0 + 2.0 * s_ddot)).abs() < 1e-10);
    let position = Vector3::new(0.7 * s.cos(), 0.7 * s.sin(), 0.2 * s);
    assert!((state.position - position).norm() < 1e-10);
}

#[test]
fn a_bead_sets_out_from_the_end_of_its_curve() {
    let line = Spline::through(&[[0.0; 3], [2.0, 0.0, 0.0]], false, 0.0).unwrap();
    let mut made = bead(|b, on| {
        b.attach_free("bead", on, OnCurve::new(line.clone()))
            .unwrap()
    });
    let (state, _) = moved(&mut made, [0.0, 1.5], 0.8, 40);
    assert!((state.position - Vector3::new(1.2, 0.0, 0.0)).norm() < 1e-10);
}

/// The sphere of radius one about the parent, without its poles on e2: angle u about e2 and
/// latitude v, from the lowest point.
#[derive(Clone)]
struct Sphere;

impl Surface for Sphere {
    fn at<S: Scalar>(&self, u: S, v: S) -> Vector3<S> {
        let across = v.cos();
        Vector3::new(u.sin() * across, v.sin(), -u.cos() * across)
    }

    fn margin(&self, _u: f64, v: f64) -> f64 {
        FRAC_PI_2 - v.abs()
    }
}

#[test]
fn a_point_at_the_edge_of_a_surface_ends_the_motion_by_name() {
    let mut made = bead(|b, on| b.attach_free("bead", on, OnSurface::new(Sphere)).unwrap());
    let n = made.0.pattern().dim();
    let (q, mut v) = (vec![0.0; n], vec![0.0; n]);
    // Fast enough along e2 to come over the pole.
    assert!(made.0.set(&mut v, made.1.coordinates[1], 0, 9.0));
    let mut progress = Progress::new(start(&made.0, 0.0, &q, &v).unwrap());
    let go_on = &mut |_: &mut Context, _: &StepReport<'_>| ControlFlow::Continue(());
    let options = tight(Scheme::default(), 2.0, 0.01);
    let error = integrate(&mut made.0, &mut progress, &options, go_on).unwrap_err();
    let said = error.to_string();
    assert_says(&said, &["joint at node bead left its surface over an edge"]);
    let reached = made.0.node_state(made.1.frame).position;
    assert!(reached.y > 0.9, "{reached}");
}
