//! Where charts of joints end: they change, or an error names the joint.

use crate::support::dynamics::{assert_order, configure, grounded, observed, tight};
use crate::support::prelude::*;
use crate::support::program::assert_says;

/// A body that is the same about all axes, on whatever `hang` makes on the ground; no weight.
fn ball(hang: impl Fn(&mut ModelBuilder, NodeId) -> JointNodes) -> (Context, JointNodes) {
    let (mut b, ground) = grounded();
    let made = hang(&mut b, ground);
    let sphere = RigidBody::new(2.0, Matrix3::identity() * 0.3, Vector3::zeros()).unwrap();
    b.element("ball", sphere, &[made.frame]).unwrap();
    // Something is free, whatever is driven.
    let free = b.node("free", [1.0, 0.0, 0.0]).unwrap();
    b.element("free", sphere, &[free]).unwrap();
    (Context::new(b.build().unwrap()), made)
}

/// Runs with rates of the released coordinates; the orientation at each step is handed to `at`.
fn run(
    context: &mut Context,
    made: &JointNodes,
    rates: &[f64],
    to: f64,
    at: &mut dyn FnMut(f64, &NodeState),
) -> Result<Progress, DynamicsError> {
    let n = context.pattern().dim();
    let (q, mut v) = (vec![0.0; n], vec![0.0; n]);
    for (&node, &rate) in made.coordinates.iter().zip(rates) {
        assert!(context.set(&mut v, node, 0, rate));
    }
    let mut progress = Progress::new(start(context, 0.0, &q, &v)?);
    let options = tight(Scheme::default(), to, 0.01);
    let seen = &mut |context: &mut Context, step: &StepReport<'_>| {
        configure(context, &step.progress.state);
        at(step.progress.state.t, &context.node_state(made.frame));
        ControlFlow::Continue(())
    };
    integrate(context, &mut progress, &options, seen)?;
    Ok(progress)
}

#[test]
fn a_universal_joint_goes_through_a_right_angle_and_any_number_of_turns() {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let cross = Universal::new(axes).unwrap();
    let (mut context, made) = ball(|b, on| b.attach("cross", on, cross).unwrap());
    // The axes stay at right angles, so T = ½ J (α̇² + β̇²): both angles grow evenly.
    let (alpha, beta) = (1.0, 3.0);
    let mut largest = 0.0_f64;
    let progress = run(&mut context, &made, &[alpha, beta], 5.0, &mut |t, state| {
        let exact = so3::rotation(&(Vector3::x() * (alpha * t)))
            * so3::rotation(&(Vector3::y() * (beta * t)));
        largest = largest.max((state.R - exact).norm());
    });
    let progress = progress.unwrap();
    assert!(beta * progress.state.t > 2.0 * TAU);
    assert!(largest < 1e-10, "{largest:e}");
    assert_eq!(progress.summary.chart_changes, 0);
}

/// A point mass that hangs along the third axis of the shaft: at β = 90° no mass acts on α, which turns by
/// half a turn in a moment as the mass passes nearby. Its way is a great circle at constant speed.
#[test]
fn a_point_mass_on_a_universal_joint_passes_a_right_angle_on_a_great_circle() {
    let (mut b, ground) = grounded();
    let cross = Universal::new([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).unwrap();
    let made = b.attach("cross", ground, cross).unwrap();
    let bob = b.offset("bob", made.frame, [0.0, 0.0, -1.0]).unwrap();
    b.element("mass", PointMass::new(1.0).unwrap(), &[bob])
        .unwrap();
    let mut context = Context::new(b.build().unwrap());
    let beta = 1.2_f64;
    let (sin, cos) = beta.sin_cos();
    for rates in [[1.0, 2.0], [0.2, 2.0]] {
        // x = R(α e1) R(β e2) (−e3) and its rate, at α = 0.
        let from = Vector3::new(-sin, 0.0, -cos);
        let velocity = Vector3::new(-rates[1] * cos, rates[0] * cos, rates[1] * sin);
        let speed = velocity.norm();
        let errors = [1e-3, 5e-4].map(|h| {
            let options = tight(Scheme::default(), 0.4, h);
            let mut last = (Vector3::zeros(), 0.0);
            let start = [&[0.0, beta][..], &rates];
            observed(&mut context, start, &options, &mut |context, step| {
                last = (context.node_state(bob).position, step.progress.state.q[0]);
            });
            assert!(last.1 > 2.0, "not beyond: {}", last.1);
            let (sin, cos) = (speed * 0.4).sin_cos();
            (last.0 - (from * cos + velocity / speed * sin)).norm()
        });
        assert_order(format!("{rates:?}"), &errors, 2.0, 0.2);
        assert!(errors[1] < 1e-2, "{rates:?}: {errors:?}");
    }
}

#[test]
fn a_tilt_of_a_whole_turn_is_refused_with_the_name_of_the_coupling() {
    let axis = [0.0, 0.0, 1.0];
    let (mut context, made) = ball(|b, on| {
        let coupling = ConstantVelocity::new([axis; 2]).unwrap();
        let made = b.attach("coupling", on, coupling).unwrap();
        b.prescribe_coordinate(made.coordinates[0], 0, Proportional(2.0));
        b.prescribe_coordinate(made.coordinates[1], 0, Constant(0.0));
        made
    });
    let mut reached = 0.0_f64;
    let ended = run(&mut context, &made, &[], 4.0, &mut |t, state| {
        reached = t;
        // The shaft is tilted by 2 t, through half a turn and beyond.
        let tilted = (state.R * Vector3::z()).z;
        assert!((tilted - (2.0 * t).cos()).abs() < 1e-12);
    });
    let said = ended.unwrap_err().to_string();
    let over = "joint at node coupling left its tilts of less than a whole turn";
    assert_says(&said, &[over]);
    assert!((0.99..1.0).contains(&(2.0 * reached / TAU)), "{reached}");
}

/// A line with ends.
#[derive(Clone)]
struct Rail;

impl Curve for Rail {
    fn at<S: Scalar>(&self, s: S) -> Vector3<S> {
        Vector3::new(s, S::zero(), S::zero())
    }

    fn margin(&self, s: f64) -> f64 {
        1.0 - s.abs()
    }
}

#[test]
fn the_end_of_a_curve_is_refused_with_the_name_of_the_point() {
    let (mut context, made) =
        ball(|b, on| b.attach_free("carriage", on, OnCurve::new(Rail)).unwrap());
    let mut reached = 0.0_f64;
    let ended = run(&mut context, &made, &[2.0], 4.0, &mut |t, state| {
        reached = state.position.x;
        assert!((state.position.x - 2.0 * t).abs() < 1e-12);
    });
    let said = ended.unwrap_err().to_string();
    let over = "joint at node carriage left its curve over an end";
    assert_says(&said, &[over]);
    assert!(reached <= 1.0 && reached > 0.98, "{reached}");
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
fn the_edge_of_a_surface_is_refused_with_the_name_of_the_point() {
    let (mut context, made) =
        ball(|b, on| b.attach_free("bead", on, OnSurface::new(Sphere)).unwrap());
    let mut reached = 0.0_f64;
    // Along e2, over the pole.
    let ended = run(&mut context, &made, &[0.0, 2.0], 4.0, &mut |t, state| {
        reached = state.position.y;
        assert!((reached - (2.0 * t).sin()).abs() < 1e-12);
    });
    let said = ended.unwrap_err().to_string();
    assert_says(&said, &["joint at node bead left its surface over an edge"]);
    assert!(reached > 0.99, "{reached}");
}

#[test]
fn a_spring_along_a_line_lets_its_nodes_turn() {
    // At the centre of a body that turns about it, the other end held: nothing acts.
    let (rate, to) = (10.0, 2.0);
    let (mut b, ground) = grounded();
    let end = b.node("end", [1.0, 0.0, 0.0]).unwrap();
    let sphere = RigidBody::new(1.0, Matrix3::identity(), Vector3::zeros()).unwrap();
    b.element("body", sphere, &[end]).unwrap();
    let positions = [ground, end].map(|n| b.position(n));
    let spring = AxialSpring::new(&positions, 1.0, 0.5).unwrap();
    b.element("spring", spring, &[ground, end]).unwrap();
    let mut context = Context::new(b.build().unwrap());
    let (q, mut v) = (vec![0.0; 6], vec![0.0; 6]);
    v[5] = rate;
    let options = tight(Scheme::default(), to, 0.01);
    let run = observed(&mut context, [&q, &v], &options, &mut |context, step| {
        let now = context.node_state(end);
        let turned = so3::rotation(&Vector3::new(0.0, 0.0, rate * step.progress.state.t));
        assert!((now.R - turned).norm() < 1e-9 && now.d.norm() < 1e-12);
    });
    assert_eq!(run.state.t, to);
}
