//! Rigid motions with published or closed solutions: tops, a tumbling body, a pendulum over many
//! turns, Hooke's joint.

#![allow(non_snake_case, clippy::unwrap_used)]

use crate::support::dynamics::*;
use nalgebra::{Matrix3, Matrix6, SVector, Vector3, Vector6};
use pullback::elements::body::{PointMass, RigidBody};
use pullback::elements::joint::Spherical;
use pullback::elements::model::{Context, Dof, ModelBuilder, NodeId};
use pullback::elements::spring::Bushing;
use pullback::elements::time::{Constant, Sine, TimeFunction};
use pullback::integrators::dynamics::Scheme;
use pullback::manifold::so3::Quaternion;
use pullback::manifold::system::System;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

const G: f64 = 9.81;

/// Rotation and angular velocity (global components) of `node` after `n` steps from the reference
/// configuration with angular velocity `omega`, and the number of changes of chart.
fn spin(
    (mut context, node): (Context, NodeId),
    omega: Vector3<f64>,
    scheme: Scheme,
    to: f64,
    n: usize,
) -> (Matrix3<f64>, Vector3<f64>, usize) {
    let q = vec![0.0; context.pattern().dim()];
    let v = turning(&mut context, &q, omega);
    let options = tight(scheme, to, to / n as f64);
    let progress = observed(&mut context, [&q, &v], &options, &mut |_, _| ());
    configure(&mut context, &progress.state);
    let s = context.node_state(node);
    (s.R, s.omega, progress.summary.chart_changes)
}

// Heavy top ------------------------------------------------------------------------------------

/// The heavy top of Géradin & Cardona: m = 15, centre of mass at e2 from the fixed point. Either
/// its own node is held in place, or it hangs from a spherical joint.
fn top(joint: bool) -> (Context, NodeId) {
    let mut b = ModelBuilder::new();
    let point = b.node("point", [0.0; 3]).unwrap();
    let node = if joint {
        b.support(point, &Dof::ALL);
        b.attach_free("top", point, Spherical).unwrap().frame
    } else {
        b.support(point, &Dof::TRANSLATIONS);
        point
    };
    let J = Matrix3::from_diagonal(&Vector3::new(0.234375, 0.46875, 0.234375));
    body(
        &mut b,
        "top",
        node,
        RigidBody::new(15.0, J, Vector3::y()).unwrap(),
    );
    (Context::new(b.build().unwrap()), node)
}

#[test]
fn the_heavy_top_on_its_point_and_on_a_spherical_joint() {
    // published.json, R01: Brüls, Cardona & Arnold 2012; position of the centre of mass at 0.2.
    let exact = Vector3::new(0.6055505613771, 0.5989576817949, -0.52398302743);
    let omega = Vector3::new(0.0, 150.0, -4.61538);
    for scheme in second_order() {
        let errors = [2000, 4000, 8000].map(|n| {
            let [(R, w, changes), (R_joint, w_joint, changes_joint)] =
                [false, true].map(|joint| spin(top(joint), omega, scheme, 0.2, n));
            assert!((R - R_joint).amax() < 1e-9 && (w - w_joint).norm() < 1e-7);
            // 30 rad about e2 alone.
            assert!(
                changes >= 4 && changes_joint >= 4,
                "{changes} {changes_joint}"
            );
            (R * Vector3::y() - exact).norm()
        });
        for slope in slopes(&errors) {
            assert!((slope - 2.0).abs() < 0.1, "{}: {errors:?}", scheme.name);
        }
        assert!(errors[2] < 1e-3, "{errors:?}");
    }
}

// Free body ------------------------------------------------------------------------------------

/// Euler's equations and Q̇ = ½ Q (0, Ω) for the quaternion (w, v): y = (w, v, Ω).
fn euler(J: &Vector3<f64>, y: &SVector<f64, 7>) -> SVector<f64, 7> {
    let (w, v) = (y[0], Vector3::new(y[1], y[2], y[3]));
    let Omega = Vector3::new(y[4], y[5], y[6]);
    let w_dot = -0.5 * v.dot(&Omega);
    let v_dot = (Omega * w + v.cross(&Omega)) * 0.5;
    let rate = -Omega.cross(&J.component_mul(&Omega)).component_div(J);
    SVector::<f64, 7>::from_fn(|i, _| match i {
        0 => w_dot,
        1..4 => v_dot[i - 1],
        _ => rate[i - 4],
    })
}

#[test]
fn a_free_body_near_its_middle_axis() {
    // published.json, R03.
    let J = Vector3::new(1.0, 2.0, 3.0);
    let start = Vector3::new(0.1, 10.0, 0.1);
    let ode = |_: f64, y: &SVector<f64, 7>| euler(&J, y);
    let solve = |to: f64, n: usize| {
        let y = SVector::<f64, 7>::from_fn(|i, _| match i {
            0 => 1.0,
            1..4 => 0.0,
            _ => start[i - 4],
        });
        integrate_ode(&ode, y, to, n)
    };
    let (R_of, Omega_of) = (
        |y: &SVector<f64, 7>| {
            let v = Vector3::new(y[1], y[2], y[3]);
            Quaternion { w: y[0], v }.rotation()
        },
        |y: &SVector<f64, 7>| Vector3::new(y[4], y[5], y[6]),
    );
    // The integration in this test against the published values and the period of Jacobi's
    // functions, 4K/s.
    let at_one = solve(1.0, 20_000);
    let published = [
        0.24270299,
        0.11814413,
        -0.82272015,
        -0.50026871,
        -8.74573438,
        4.84996187,
        5.05001221,
    ];
    for k in 0..7 {
        assert!((at_one[k] - published[k]).abs() < 1e-8, "{at_one}");
    }
    let (k2, s) = (0.999_800_059_982_005_f64, 5.774_368_652_357_88);
    let period = 4.0 * elliptic_K(k2.sqrt()) / s;
    assert!((period - 3.910_573_419_726_87).abs() < 1e-10);
    let after = solve(period, 80_000);
    assert!((Omega_of(&after) - start).norm() < 1e-8, "{after}");

    let free = || {
        let mut b = ModelBuilder::new();
        let node = b.node("body", [0.0; 3]).unwrap();
        let body = RigidBody::new(1.0, Matrix3::from_diagonal(&J), Vector3::zeros()).unwrap();
        b.element("body", body, &[node]).unwrap();
        (Context::new(b.build().unwrap()), node)
    };
    for (to, exact, turns) in [(1.0, at_one, 1), (period, after, 5)] {
        for scheme in second_order() {
            let n = (1000.0 * to) as usize;
            let errors = [n, 2 * n, 4 * n].map(|n| {
                let (R, omega, changes) = spin(free(), start, scheme, to, n);
                assert!(changes >= turns, "{changes}");
                let rotation = (R - R_of(&exact)).norm();
                vec![rotation, (R.tr_mul(&omega) - Omega_of(&exact)).norm()]
            });
            let names = ["rotation", "angular velocity"];
            assert_slopes(scheme.name, &names, &errors, 2.0, 0.1);
        }
    }
}

// Pendulum -------------------------------------------------------------------------------------

/// A point mass a metre below a revolute joint about −e2, so that a positive angle moves it
/// towards e1: position, angle and rate after `n` steps from an angle and a rate.
fn pendulum(scheme: Scheme, start: [f64; 2], to: f64, n: usize) -> (Vector3<f64>, [f64; 2], usize) {
    let (mut b, ground) = grounded();
    let hinge = revolute(&mut b, "hinge", ground, [0.0, -1.0, 0.0]);
    let end = b.offset("end", hinge.frame, [0.0, 0.0, -1.0]).unwrap();
    let mass = PointMass::new(1.0).unwrap();
    let weight = mass.weight([0.0, 0.0, -G], Constant(1.0));
    b.element("mass", mass, &[end]).unwrap();
    b.element("weight", weight, &[end]).unwrap();
    let mut context = Context::new(b.build().unwrap());
    let options = tight(scheme, to, to / n as f64);
    let [q, v] = start.map(|x| [x]);
    let progress = observed(&mut context, [&q, &v], &options, &mut |_, _| ());
    configure(&mut context, &progress.state);
    let angle = context.coordinate(hinge.coordinates[0], 0).unwrap();
    let changes = progress.summary.chart_changes;
    (context.node_state(end).position, angle, changes)
}

#[test]
fn the_pendulum_of_iftomm() {
    // published.json, R04: from (−1, 0) at rest.
    for (to, x, z) in [
        (1.0, 0.986291751131875, -0.165010853125541),
        (5.0, -0.942305435043757, -0.334754338414001),
    ] {
        for scheme in second_order() {
            let errors = [200, 400, 800].map(|n| {
                let n = n * to as usize;
                let (position, _, _) = pendulum(scheme, [-FRAC_PI_2, 0.0], to, n);
                (position - Vector3::new(x, 0.0, z)).norm()
            });
            for slope in slopes(&errors) {
                assert!((slope - 2.0).abs() < 0.1, "{}: {errors:?}", scheme.name);
            }
        }
    }
}

#[test]
fn a_pendulum_over_many_turns() {
    // θ̇² = ω² − 4g sin²(θ/2): a turn takes 4K(k)/ω with k² = 4g/ω².
    let omega: f64 = 8.0;
    let turn = 4.0 * elliptic_K(2.0 * G.sqrt() / omega) / omega;
    let turns = 6;
    for scheme in second_order() {
        let errors = [2000, 4000, 8000].map(|n| {
            let (_, [angle, rate], changes) =
                pendulum(scheme, [0.0, omega], f64::from(turns) * turn, n);
            // Poses have no charts.
            assert_eq!(changes, 0);
            vec![(angle - f64::from(turns) * TAU).abs(), (rate - omega).abs()]
        });
        assert_slopes(scheme.name, &["angle"], &errors, 2.0, 0.1);
        assert!(errors[2][0] < 1e-2, "{errors:?}");
    }
}

// Hooke's joint --------------------------------------------------------------------------------

/// Angle of the second shaft for that of the first, tan θ₁ = cos β tan θ₂, and the ratio of speeds.
fn hooke_relation(beta: f64, first: f64) -> [f64; 2] {
    let ((s, c), (s1, c1)) = (beta.sin_cos(), first.sin_cos());
    [s1.atan2(c1 * c), c / (1.0 - (s * c1).powi(2))]
}

/// Largest errors of the angle and the speed of the second shaft, with a coupling of stiffness k.
fn hooke(beta: f64, k: f64) -> [f64; 2] {
    let (mut b, ground) = grounded();
    let (s, c) = beta.sin_cos();
    // Shafts in the plane of e1 and e2; the input yoke's axis is in it at the start, that of the
    // output yoke perpendicular to it.
    let input = revolute(&mut b, "input", ground, [1.0, 0.0, 0.0]);
    // More than two turns and back.
    let drive = Sine {
        offset: 7.0,
        ..sine(-7.0, 1.0, FRAC_PI_2)
    };
    b.prescribe_coordinate(input.coordinates[0], 0, drive);
    let cross = revolute(&mut b, "cross", input.frame, [0.0, 1.0, 0.0]);
    let yoke = revolute(&mut b, "yoke", cross.frame, [0.0, 0.0, 1.0]);
    let output = revolute(&mut b, "output", ground, [c, s, 0.0]);
    let J = Matrix3::identity() * 0.01;
    for (name, node) in [
        ("cross", cross.frame),
        ("yoke", yoke.frame),
        ("output", output.frame),
    ] {
        let body = RigidBody::new(1.0, J, Vector3::zeros()).unwrap();
        b.element(name, body, &[node]).unwrap();
    }
    // The yoke and the second shaft are one: the loop is closed by a stiff bushing.
    let K = Matrix6::from_diagonal(&Vector6::new(1.0, 1.0, 1.0, k, k, k));
    let ends = [Vector3::zeros(); 2];
    let coupling = Bushing::new(&ends, &Matrix3::identity(), &K, &Matrix6::zeros()).unwrap();
    b.element("coupling", coupling, &[yoke.frame, output.frame])
        .unwrap();
    let mut context = Context::new(b.build().unwrap());
    let mut worst = [0.0_f64; 2];
    // A scheme that damps the vibrations of the coupling.
    let options = tight(Scheme::chung_hulbert(0.0).unwrap(), PI, PI / 2000.0);
    observed(&mut context, [&[], &[]], &options, &mut |context, step| {
        let [first, rate, _] = drive.at(step.progress.state.t, &[]);
        let [second, speed] = context.coordinate(output.coordinates[0], 0).unwrap();
        let [exact, ratio] = hooke_relation(beta, first);
        let gap = (second - exact) / TAU;
        worst[0] = worst[0].max((gap - gap.round()).abs() * TAU);
        worst[1] = worst[1].max((speed - ratio * rate).abs());
    });
    worst
}

#[test]
fn hookes_joint_from_two_revolute_joints() {
    // published.json, R08: degrees, degrees, ratio of speeds.
    for [beta, first, second, ratio] in [
        [30.0_f64, 0.0, 0.0, 1.15470053838],
        [30.0, 30.0, 33.690067526, 1.06587742004],
        [30.0, 45.0, 49.1066053509, 0.989743318611],
        [45.0, 60.0, 67.7923457014, 0.808122035642],
    ] {
        let found = hooke_relation(beta.to_radians(), f64::to_radians(first));
        assert!((found[0].to_degrees() - second).abs() < 1e-9, "{found:?}");
        assert!((found[1] - ratio).abs() < 1e-10, "{found:?}");
    }
    // The coupling gives way by moments over its stiffness.
    for beta in [PI / 6.0, PI / 4.0] {
        let errors = [1e3, 1e4, 1e5].map(|k| hooke(beta, k));
        for pair in errors.windows(2) {
            let ratio = pair[0][0] / pair[1][0];
            assert!((ratio - 10.0).abs() < 0.5, "angles at {beta}: {errors:?}");
        }
        // Speeds to a thousandth of the greatest: they show the coupling's vibrations.
        let greatest = 7.0 / beta.cos();
        assert!(
            errors[2][1] < 1e-3 * greatest,
            "speeds at {beta}: {errors:?}"
        );
    }
}
