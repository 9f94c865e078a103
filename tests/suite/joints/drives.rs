//! Coordinates of joints that follow functions of time: where, how fast and with what force the hung
//! frame moves, for every joint of the library.

use crate::support::dynamics::{assert_slopes, grounded, observed, point, revolute, sine, tight};
use crate::support::prelude::*;

const MASS: f64 = 2.0;

#[derive(Clone, Copy)]
struct Bow;

impl Curve for Bow {
    fn at<S: Scalar>(&self, s: S) -> Vector3<S> {
        Vector3::new(s, s * s * 0.4, s.sin() * 0.3)
    }
}

#[derive(Clone, Copy)]
struct Saddle;

impl Surface for Saddle {
    fn at<S: Scalar>(&self, u: S, v: S) -> Vector3<S> {
        Vector3::new(u, v, u * u - v * v * 0.5)
    }
}

/// The function that drives coordinate `k` of a joint.
fn function(k: usize) -> pullback::elements::time::Sine {
    sine(0.9 - 0.2 * k as f64, 2.0 + 0.7 * k as f64, 0.3 * k as f64)
}

/// First and second derivative by central differences of the fourth order.
fn differences(f: &dyn Fn(f64) -> Vector3<f64>, t: f64) -> [Vector3<f64>; 2] {
    let h = 1e-2;
    let at = |k: f64| f(t + k * h);
    // Richardson's extrapolation of the differences over h and 2h.
    let first = |k: f64| (at(k) - at(-k)) / (2.0 * k * h);
    let second = |k: f64| (at(k) + at(-k) - at(0.0) * 2.0) / (k * h).powi(2);
    [
        (first(1.0) * 4.0 - first(2.0)) / 3.0,
        (second(1.0) * 4.0 - second(2.0)) / 3.0,
    ]
}

/// Drives all coordinates of a joint on a frame that is driven too, and compares the hung frame, and
/// the force that moves the mass on it, with the pose and its differences in time.
#[track_caller]
fn driven<J: Joint<D> + Copy + 'static, const D: usize>(what: &str, joint: J, turns_freely: bool) {
    let mut b = ModelBuilder::new();
    let base = b.node("base", [0.0; 3]).unwrap();
    for dof in Dof::ALL {
        let k = dof.index();
        b.prescribe(base, dof, sine(0.3, 1.0 + 0.1 * k as f64, 0.2 * k as f64));
    }
    let made = match turns_freely {
        true => b.attach_free("joint", base, joint).unwrap(),
        false => b.attach("joint", base, joint).unwrap(),
    };
    let mut own = 0;
    for &node in &made.coordinates {
        for k in 0..b.quantities(node).len() {
            b.prescribe_coordinate(node, k, function(own));
            own += 1;
        }
    }
    assert_eq!(own, if turns_freely { D + 3 } else { D });
    b.element("mass", PointMass::new(MASS).unwrap(), &[made.frame])
        .unwrap();
    let free = b.node("free", [0.0; 3]).unwrap();
    let sphere = RigidBody::new(1.0, Matrix3::identity(), Vector3::zeros()).unwrap();
    b.element("free", sphere, &[free]).unwrap();
    let mut context = Context::new(b.build().unwrap());
    let start = joint.pose(0.0, &SVector::zeros()).d;
    let pose = |t: f64| {
        let q = SVector::<f64, 6>::from_fn(|k, _| {
            sine(0.3, 1.0 + 0.1 * k as f64, 0.2 * k as f64).at(t, &[])[0]
        });
        let own = joint.pose(t, &SVector::from_fn(|k, _| function(k).at(t, &[])[0]));
        let child = Pose::of(&q, 0).translated(&own.d).rotated(&own.rotation);
        let psi = Vector3::from_fn(|k, _| function(D + k).at(t, &[])[0]);
        let rotation = match turns_freely {
            true => so3::quaternion(&psi),
            false => child.rotation,
        };
        let d = child.d - start;
        Pose { d, rotation }
    };
    let zeros = vec![0.0; context.pattern().dim()];
    for t in [0.0, 0.4, 1.1, 2.3] {
        let at = Point {
            t,
            q: &zeros,
            v: &zeros,
            a: &zeros,
        };
        let mut r = zeros.clone();
        context.evaluate(at, Evaluation::residual(&mut r)).unwrap();
        let state = context.node_state(made.frame);
        let turn = |t: f64| so3::rotation(&so3::log_quaternion(&pose(t).rotation));
        assert!((state.d - pose(t).d).norm() < 1e-13, "{what} at {t}");
        assert!((state.R - turn(t)).norm() < 1e-13, "{what} at {t}");
        let [velocity, acceleration] = differences(&|t| pose(t).d, t);
        let close = |a: Vector3<f64>, b: Vector3<f64>, name: &str| {
            assert!((a - b).norm() < 2e-6, "{what} at {t}: {name} {a} {b}");
        };
        close(state.velocity, velocity, "velocity");
        close(state.acceleration, acceleration, "acceleration");
        // Ṙ e = ω × (R e).
        for e in [Vector3::x(), Vector3::y()] {
            let [rate, _] = differences(&|t| turn(t) * e, t);
            close(state.omega.cross(&(state.R * e)), rate, "angular velocity");
        }
        let [force, moment] = context.joint_force(made.frame).unwrap();
        close(force, acceleration * MASS, "force");
        assert!(moment.norm() < 1e-12);
    }
}

#[test]
fn every_coordinate_of_every_joint_follows_a_function_of_time() {
    let (axis, other) = ([1.0, -2.0, 0.5], [0.3, 1.0, 0.9]);
    driven("revolute", Revolute::new(axis).unwrap(), false);
    driven("prismatic", Prismatic::new(axis).unwrap(), false);
    driven("helical", Helical::new(axis, 0.7).unwrap(), false);
    driven("cylindrical", Cylindrical::new(axis).unwrap(), false);
    driven("universal", Universal::new([axis, other]).unwrap(), false);
    let shafts = ConstantVelocity::new([axis, other]).unwrap();
    driven("constant velocity", shafts, false);
    driven("planar", Planar::new(axis, other).unwrap(), false);
    driven("spherical", Spherical, true);
    driven("curve", OnCurve::new(Bow), true);
    driven("surface", OnSurface::new(Saddle), true);
}

#[test]
fn a_carriage_on_a_driven_boom_is_flung_and_pulls_at_the_drive() {
    let (omega, first, to) = (2.5, 0.4, 0.8);
    let errors: Vec<Vec<f64>> = [100, 200, 400]
        .map(|steps| {
            let (mut b, ground) = grounded();
            let hub = revolute(&mut b, "hub", ground, [0.0, 0.0, 1.0]);
            b.prescribe_coordinate(hub.coordinates[0], 0, Proportional(omega));
            let rail = Prismatic::new([1.0, 0.0, 0.0]).unwrap();
            let boom = b.attach("boom", hub.frame, rail).unwrap();
            b.element("mass", PointMass::new(MASS).unwrap(), &[boom.frame])
                .unwrap();
            let mut context = Context::new(b.build().unwrap());
            let options = tight(Scheme::default(), to, to / steps as f64);
            let run = observed(&mut context, [&[first], &[0.0]], &options, &mut |_, _| ());
            // r̈ = Ω² r, and the moment of the drive is the rate of m r² Ω.
            let (cosh, sinh) = ((omega * to).cosh(), (omega * to).sinh());
            let (r, rate) = (first * cosh, first * omega * sinh);
            let state = &run.state;
            let at = point(state);
            context
                .evaluate(at, Evaluation::residual(&mut [0.0]))
                .unwrap();
            let [_, moment] = context.joint_force(hub.frame).unwrap();
            let exact = 2.0 * MASS * r * rate * omega;
            vec![
                (state.q[0] - r).abs(),
                (state.v[0] - rate).abs(),
                (moment.z - exact).abs(),
            ]
        })
        .into();
    let names = ["way", "rate", "moment"];
    assert_slopes("boom", &names, &errors, 2.0, 0.1);
    assert!(errors[2].iter().all(|e| *e < 1e-2), "{errors:?}");
}
