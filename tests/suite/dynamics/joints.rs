//! Joints against the same system described in another way: ordinary differential equations of minimal
//! coordinates integrated here.

use crate::support::dynamics::*;
use crate::support::prelude::*;
use nalgebra::Matrix2;

const G: f64 = 9.81;

/// Zeros with some coordinates set.
fn values(context: &Context, set: &[(NodeId, usize, f64)]) -> Vec<f64> {
    let mut x = vec![0.0; context.pattern().dim()];
    for &(node, k, value) in set {
        assert!(context.set(&mut x, node, k, value));
    }
    x
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
    let errors: [Vec<f64>; 3] = [400, 800, 1600].map(|n| {
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
        configure(&mut context, &progress.state);
        let found = [u, w].map(|n| context.coordinate(n, 0).unwrap()).concat();
        // The tip is where the angles say.
        let hang = |angle: f64, l: f64| so3::rotation(&(e * angle)) * Vector3::new(0.0, 0.0, -l);
        let position = hang(found[0], l[0]) + hang(found[0] + found[2], l[1]);
        assert!((context.node_state(tip).position - position).norm() < 1e-13);
        let pairs = found.iter().zip(exact);
        pairs.map(|(found, exact)| (found - exact).abs()).collect()
    });
    let names = ["first angle", "its rate", "second angle", "its rate"];
    assert_slopes("double pendulum", &names, &errors, 2.0, 0.1);
    assert!(errors[2][0] < 1e-4, "{errors:?}");
}
