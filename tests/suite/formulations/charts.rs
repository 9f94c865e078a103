//! Another chart of rotations gives the same motion and the same equilibrium.

use crate::support::dynamics::{assert_order, formulated, observed, turning};
use crate::support::prelude::*;
use crate::support::program::example;
use pullback::conformance;
use pullback::manifold::chart::RotationChart;

/// A clamped beam rolled up into two circles by a moment: its end turns by 4π.
#[test]
fn a_beam_rolls_up_alike_in_both_charts() {
    let ends = [Formulation::Total, Formulation::WienerMilenkovic].map(|formulation| {
        let mut job = formulated(&example("rollup"), formulation);
        let Plan::Static(options) = job.plan else {
            panic!("statics");
        };
        let mut run = LoadSteps::new(&mut job.context, Vec::new(), &options).unwrap();
        run.finish().unwrap();
        assert!(run.summary().chart_changes > 0);
        let tip = run.system().find("tip").unwrap();
        run.system().node_state(tip)
    });
    // Its tip is back at the root.
    let [total, other] = ends;
    assert!((other.position - total.position).norm() < 1e-8, "{ends:?}");
    assert!((other.R - total.R).norm() < 1e-8, "{ends:?}");
    assert!(other.position.norm() < 1e-8, "{ends:?}");
}

/// c = 4 sin(ψ/4) e: a chart of a user.
#[derive(Clone, Copy)]
struct Sines;

impl RotationChart for Sines {
    fn quaternion<S: Scalar>(&self, c: &Vector3<S>) -> Quaternion<S> {
        let square = c.dot(c);
        let cosine = (S::one() - square * S::constant(1.0 / 16.0)).sqrt();
        Quaternion {
            w: S::one() - square * S::constant(1.0 / 8.0),
            v: c * (cosine * S::constant(0.5)),
        }
    }

    fn coordinates<S: Scalar>(&self, rotation: &Quaternion<S>) -> Vector3<S> {
        let cosine = ((S::one() + rotation.w) * S::constant(0.5)).sqrt();
        rotation.v * (S::constant(2.0) / cosine)
    }

    fn margin(&self, c: &Vector3<f64>) -> f64 {
        4.0 - c.norm()
    }
}

/// A ball that turns twice: its rotation is ω t, and the error of the trapezoidal rule falls with h².
#[test]
fn a_body_turns_in_a_chart_of_the_user() {
    conformance::chart(&Sines).assert();
    let omega = Vector3::new(3.0, -1.0, 2.0);
    let to = 2.0 * std::f64::consts::TAU / omega.norm();
    let errors = [200.0, 400.0, 800.0].map(|steps| {
        let mut b = ModelBuilder::new();
        let node = b.node("ball", [0.0; 3]).unwrap();
        let ball = RigidBody::new(1.3, Matrix3::identity() * 0.7, Vector3::zeros()).unwrap();
        b.element("ball", ball, &[node]).unwrap();
        b.chart_rotations(Sines);
        let mut context = Context::new(b.build().unwrap());
        let q = vec![0.0; 6];
        let v = turning(&mut context, &q, omega);
        let options = DynamicOptions::new(0.9 * to, 0.9 * to / steps);
        let run = observed(&mut context, [&q, &v], &options, &mut |_, _| ());
        assert!(run.summary.chart_changes > 1);
        let found = context.node_state(node).R;
        (found - so3::rotation(&(omega * (0.9 * to)))).norm()
    });
    assert_order("chart", &errors, 2.0, 0.05);
}
