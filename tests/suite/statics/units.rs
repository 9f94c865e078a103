//! The units of length, force and time are the user's: a model in micrometres is solved as one in
//! metres, with the same iterations to the same digits.

#![allow(non_snake_case)]

use crate::support::beams::beam;
use crate::support::dynamics::{grounded, observed, revolute};
use nalgebra::{Matrix3, Matrix6};
use pullback::elements::body::RigidBody;
use pullback::elements::spring::{Bushing, CoordinateLaw, CoordinateSpring};
use pullback::integrators::statics::solve_statics;
use pullback::prelude::*;
use std::ops::ControlFlow;

/// A unit of length, of force and of time.
#[derive(Clone, Copy, Debug)]
struct Units {
    length: f64,
    force: f64,
    time: f64,
}

const ONE: Units = Units {
    length: 1.0,
    force: 1.0,
    time: 1.0,
};

/// Structures of micrometres and nanonewtons to planets, in powers of ten that round differently.
const OTHERS: [Units; 6] = [
    Units {
        length: 1e-7,
        force: 1e-11,
        time: 1.0,
    },
    Units {
        length: 1e-4,
        force: 1e-15,
        time: 1e-3,
    },
    Units {
        length: 1e-9,
        force: 1e-20,
        time: 1e-9,
    },
    Units {
        length: 1e3,
        force: 1e-6,
        time: 1e4,
    },
    Units {
        length: 1e3,
        force: 1e9,
        time: 1.0,
    },
    Units {
        length: 1e7,
        force: 1e20,
        time: 1e5,
    },
];

/// Tip displacement in units of length, and linear solutions, of a cantilever bent far by a force
/// across it.
fn bent(u: Units) -> (Vector3<f64>, usize) {
    let mut b = ModelBuilder::new();
    let root = b.node("root", [0.0; 3]).unwrap();
    let tip = b.node("tip", [u.length, 0.0, 0.0]).unwrap();
    let bending = u.force * u.length * u.length;
    beam(
        &mut b,
        "beam",
        [root, tip],
        8,
        Section::diagonal(
            1e4 * u.force,
            [4e3 * u.force; 2],
            bending,
            [1.5 * bending, bending],
        )
        .unwrap(),
    );
    b.support(root, &Dof::ALL);
    let force = [0.0, 2.0 * u.force, 1.0 * u.force];
    let load = NodalLoad::new(LoadKind::DeadForce, force, Proportional(1.0));
    b.element("load", load, &[tip]).unwrap();
    let mut context = Context::new(b.build().unwrap());
    let mut end = Vector3::zeros();
    let options = StaticOptions::equal_steps(4);
    let summary = solve_statics(&mut context, &mut vec![], &options, &mut |context, _| {
        end = Vector3::from_fn(|k, _| context.coordinate(tip, k).unwrap()[0]) / u.length;
        ControlFlow::Continue(())
    });
    (end, summary.unwrap().iterations)
}

#[test]
fn a_structure_of_any_size_bends_alike() {
    let (expected, iterations) = bent(ONE);
    assert!(expected.norm() > 0.5, "a large displacement");
    for units in OTHERS {
        let (found, again) = bent(units);
        let gap = (found - expected).norm();
        assert!(gap < 1e-11, "{units:?}: {gap:.1e}");
        assert_eq!(again, iterations, "{units:?}");
    }
}

/// Angle, its rate in units of time, and linear solutions of a body on a hinge with a flexible rod,
/// let go in a field of gravity.
fn swung(u: Units) -> ([f64; 2], usize) {
    let (mut b, ground) = grounded();
    let hinge = revolute(&mut b, "hinge", ground, [0.0, 1.0, 0.0]);
    let mass = u.force * u.time * u.time / u.length;
    let turning = mass * u.length * u.length;
    let J = Matrix3::from_diagonal(&Vector3::new(0.2, 0.3, 0.25)) * turning;
    let body = RigidBody::new(2.0 * mass, J, Vector3::x() * 0.4 * u.length).unwrap();
    let g = -9.0 * u.length / (u.time * u.time);
    let weight = body.weight([0.0, 0.0, g], Constant(1.0));
    b.element("body", body, &[hinge.frame]).unwrap();
    b.element("weight", weight, &[hinge.frame]).unwrap();
    let foot = b
        .offset("foot", hinge.frame, [0.5 * u.length, 0.0, 0.0])
        .unwrap();
    let tip = b.node("tip", [1.5 * u.length, 0.0, 0.0]).unwrap();
    let bending = 20.0 * u.force * u.length * u.length;
    let section = Section::diagonal(1e3 * u.force, [1e3 * u.force; 2], bending, [bending; 2])
        .unwrap()
        .with_mass(mass / u.length, J / u.length * 0.1);
    beam(&mut b, "rod", [foot, tip], 3, section);
    let mut context = Context::new(b.build().unwrap());
    let options = DynamicOptions::new(2.0 * u.time, 0.02 * u.time);
    let q = context.initial().to_vec();
    let start = [&q[..], &vec![0.0; q.len()]];
    let progress = observed(&mut context, start, &options, &mut |_, _| ());
    let [angle, rate] = context.coordinate(hinge.coordinates[0], 0).unwrap();
    ([angle, rate * u.time], progress.summary.iterations)
}

#[test]
fn a_mechanism_of_any_size_moves_alike() {
    let (expected, iterations) = swung(ONE);
    assert!(expected[0].abs() > 0.5, "a large motion: {expected:?}");
    for units in OTHERS {
        let (found, again) = swung(units);
        for k in 0..2 {
            let gap = (found[k] - expected[k]).abs();
            assert!(gap < 1e-8, "{units:?}: {found:?}, not {expected:?}");
        }
        assert_eq!(again, iterations, "{units:?}");
    }
}

/// A pendulum that is a body with its centre of mass `arm` away from a hinge, which is all that has a
/// position; a mass that is held `far` away where that is not zero.
fn pendulum(arm: f64, far: f64, k: f64, g: [f64; 3]) -> (Context, NodeId) {
    let (mut b, ground) = grounded();
    let hinge = revolute(&mut b, "hinge", ground, [0.0, 1.0, 0.0]);
    let center = Vector3::new(0.0, 0.0, -arm);
    let body = RigidBody::new(1.0, Matrix3::zeros(), center).unwrap();
    let weight = body.weight(g.map(|g| g * arm), Constant(1.0));
    b.element("body", body, &[hinge.frame]).unwrap();
    b.element("weight", weight, &[hinge.frame]).unwrap();
    let law = CoordinateLaw {
        k: k * arm * arm,
        ..CoordinateLaw::default()
    };
    b.element(
        "spring",
        CoordinateSpring::new(law).unwrap(),
        &[hinge.coordinates[0]],
    )
    .unwrap();
    if far > 0.0 {
        let other = b.node("other", [far, 0.0, 0.0]).unwrap();
        b.element("mass", PointMass::new(1.0).unwrap(), &[other])
            .unwrap();
        b.support(other, &Dof::ALL);
    }
    (Context::new(b.build().unwrap()), hinge.coordinates[0])
}

/// Arms, and positions of another part that has nothing to do with them.
fn arms() -> impl Iterator<Item = (f64, f64)> {
    let arms = [1.0, 1e-3, 1e-6, 1e-9, 1e-12, 1e6];
    (arms.into_iter()).flat_map(|arm| [0.0, 1.0, 1e3, 1e9].map(|far| (arm, far)))
}

#[test]
fn what_hangs_at_one_place_knows_no_metre() {
    // k θ = m g l (…) with a weight along x and −z of the size of the spring: θ + cos θ + sin θ = 0.
    for (arm, far) in arms() {
        let (mut context, angle) = pendulum(arm, far, 9.81, [9.81, 0.0, -9.81]);
        equilibrium(&mut context, &StaticOptions::default()).unwrap();
        let [found, _] = context.coordinate(angle, 0).unwrap();
        let gap = found + found.cos() + found.sin();
        assert!(gap.abs() < 1e-9, "{arm:e}, {far:e}: {gap:.1e}");
    }
}

#[test]
fn what_swings_at_one_place_knows_no_metre() {
    let swing = |arm: f64, far: f64| {
        let (mut context, angle) = pendulum(arm, far, 2.0, [0.0, 0.0, -9.81]);
        let u = context.unknown_at(angle, 0).unwrap();
        let n = context.initial().len();
        let (mut q, rest) = (vec![0.0; n], vec![0.0; n]);
        q[u] = 1.5;
        let options = DynamicOptions::new(1.3, 0.01);
        observed(&mut context, [&q, &rest], &options, &mut |_, _| ());
        context.coordinate(angle, 0).unwrap()
    };
    let expected = swing(1.0, 0.0);
    assert!(expected[0].abs() < 1.4, "a motion: {expected:?}");
    for (arm, far) in arms() {
        let found = swing(arm, far);
        for k in 0..2 {
            let gap = (found[k] - expected[k]).abs();
            assert!(gap < 1e-9, "{arm:e}, {far:e}: {found:?}, not {expected:?}");
        }
    }
}

#[test]
fn a_force_turned_by_a_bushing_is_followed_in_any_unit() {
    // A moment k_r (1, 1, 0) turns the end by the vector (1, 1, 0), and a force k_f e₂ that follows
    // it: the displacement is R e₂ by Rodrigues' formula.
    let psi = 2.0_f64.sqrt();
    let (s, c) = (psi.sin() / psi, (1.0 - psi.cos()) / 2.0);
    let expected = Vector3::new(c, 1.0 - c, s);
    for length in [1.0, 1e-9, 1e-3, 1e3, 1e9] {
        let mut b = ModelBuilder::new();
        let ground = b.node("ground", [0.0; 3]).unwrap();
        let end = b.node("end", [0.0; 3]).unwrap();
        b.support(ground, &Dof::ALL);
        let turning = length * length;
        let stiffness = [1.0, 1.0, 1.0, turning, turning, turning];
        let K = Matrix6::from_diagonal(&stiffness.into());
        let positions = [Vector3::zeros(); 2];
        let bushing =
            Bushing::new(&positions, &Matrix3::identity(), &K, &Matrix6::zeros()).unwrap();
        b.element("bushing", bushing, &[ground, end]).unwrap();
        let moment = [turning, turning, 0.0];
        for (name, which, load) in [
            ("moment", LoadKind::SpatialMoment, moment),
            ("force", LoadKind::FollowerForce, [0.0, length, 0.0]),
        ] {
            let load = NodalLoad::new(which, load, Proportional(1.0));
            b.element(name, load, &[end]).unwrap();
        }
        let mut context = Context::new(b.build().unwrap());
        equilibrium(&mut context, &StaticOptions::default()).unwrap();
        let found = Vector3::from_fn(|k, _| context.coordinate(end, k).unwrap()[0]) / length;
        let gap = (found - expected).norm();
        assert!(gap < 1e-8, "{length:e}: {gap:.1e}");
    }
}
