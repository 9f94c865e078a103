//! The units of length, force and time are the user's: a model in micrometres is solved as one in
//! metres, with the same iterations to the same digits.

#![allow(non_snake_case)]

use nalgebra::Matrix3;
use pullback::elements::body::RigidBody;
use pullback::elements::joint::{offset, revolute};
use pullback::integrators::dynamics::{DynamicOptions, Progress, StepReport, integrate, start};
use pullback::prelude::*;

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
    let axis = Straight {
        from: b.place(root),
        to: b.place(tip),
        second: None,
        twist: 0.0,
    };
    let bending = u.force * u.length * u.length;
    let line = Line {
        elements: 8,
        order: 1,
        section: Section::diagonal(
            1e4 * u.force,
            [4e3 * u.force; 2],
            bending,
            [1.5 * bending, bending],
        )
        .unwrap(),
    };
    b.line("beam", &axis, [root, tip], &line).unwrap();
    b.support(root, &Dof::ALL);
    let force = [0.0, 2.0 * u.force, 1.0 * u.force];
    let load = NodalLoad::new(Which::DeadForce, force, Proportional(1.0));
    b.element("load", load, &[tip]).unwrap();
    let mut model = b.build().unwrap();
    let mut end = Vector3::zeros();
    let options = StaticOptions::equal_steps(4);
    let summary = solve_statics(&mut model, &mut vec![], &options, &mut |model, _| {
        end = Vector3::from_fn(|k, _| model.coordinate(tip, k).unwrap()[0]) / u.length;
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
    let mut b = ModelBuilder::new();
    let ground = b.node("ground", [0.0; 3]).unwrap();
    b.support(ground, &Dof::ALL);
    let hinge = revolute(&mut b, "hinge", ground, [0.0, 1.0, 0.0]).unwrap();
    let mass = u.force * u.time * u.time / u.length;
    let turning = mass * u.length * u.length;
    let J = Matrix3::from_diagonal(&Vector3::new(0.2, 0.3, 0.25)) * turning;
    let body = RigidBody::new(2.0 * mass, J, Vector3::x() * 0.4 * u.length).unwrap();
    let g = -9.0 * u.length / (u.time * u.time);
    let weight = body.weight([0.0, 0.0, g], Box::new(Constant(1.0)));
    b.element("body", body, &[hinge.frame]).unwrap();
    b.element("weight", weight, &[hinge.frame]).unwrap();
    let foot = offset(&mut b, "foot", hinge.frame, [0.5 * u.length, 0.0, 0.0]).unwrap();
    let tip = b.node("tip", [1.5 * u.length, 0.0, 0.0]).unwrap();
    let axis = Straight {
        from: b.place(foot),
        to: b.place(tip),
        second: None,
        twist: 0.0,
    };
    let bending = 20.0 * u.force * u.length * u.length;
    let section = Section::diagonal(1e3 * u.force, [1e3 * u.force; 2], bending, [bending; 2])
        .unwrap()
        .with_mass(mass / u.length, J / u.length * 0.1);
    let line = Line {
        elements: 3,
        order: 1,
        section,
    };
    b.line("rod", &axis, [foot, tip], &line).unwrap();
    let mut model = b.build().unwrap();
    let options = DynamicOptions::new(2.0 * u.time, 0.02 * u.time);
    let rest = vec![0.0; model.initial().len()];
    let mut progress = Progress::new(start(&model, 0.0, model.initial(), &rest).unwrap());
    let proceed = &mut |_: &mut Model, _: &StepReport<'_>| ControlFlow::Continue(());
    integrate(&mut model, &mut progress, &options, proceed).unwrap();
    let [angle, rate] = model.coordinate(hinge.angle, 0).unwrap();
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
