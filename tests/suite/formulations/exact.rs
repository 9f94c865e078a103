//! The formulations of a comparison against exact motions and against each other.

use crate::support::closures::body_of;
use crate::support::comparisons::{self, BODY};
use crate::support::dynamics::{assert_order, observed, tight};
use crate::support::heavy_top::{HELD, assert_heavy_top};
use crate::support::laboratory::options;
use crate::support::prelude::*;
use crate::support::program::assert_close;
use nalgebra::Rotation3;
use pullback::conformance as check;
use pullback::method::Method;
use pullback::studies::compare::{Comparison, ComparisonRow, ErrorQuantity, Sample};

const METHODS: [&str; 9] = [
    "newmark",
    "ul-newmark",
    "ul-hht:-0.1",
    "ul-wbz:0.8",
    "ul-bathe",
    "lie-ga:0.8",
    "lie-hht:-0.1",
    "spin-newmark",
    "wm-newmark",
];

fn compared(text: &str, methods: &[&str], steps: &[f64]) -> Comparison {
    comparisons::compared(text, &options(methods, steps)).unwrap()
}

#[test]
fn a_free_body_precesses_in_every_formulation_with_order_two() {
    let steps = [0.01, 0.005, 0.0025, 0.00125];
    let turned = "velocity = [1, 0, 0]\nrotation = [0.4, -0.9, 0.6]\nbody_angular_velocity";
    let text = BODY.replace("body_angular_velocity", turned);
    let comparison = compared(&text, &METHODS, &steps);
    // Landau & Lifshitz, Mechanics, section 33: about the fixed angular momentum with |L|/J₁, about
    // its own axis with Ω₃ (1 − J₃/J₁); all of it turned by R₀.
    let turned = Rotation3::new(Vector3::new(0.4, -0.9, 0.6));
    let exact = |t: f64| {
        let precession = Rotation3::new(Vector3::new(3.0, 0.0, 2.0) * t);
        let spin = Rotation3::new(Vector3::z() * (2.0 * t));
        (turned * precession * spin).into_inner()
    };
    for method in METHODS {
        let rows: Vec<_> = comparison.of(method).collect();
        assert!(rows.iter().all(|row| row.failure.is_none()), "{method}");
        let mean = |row: &ComparisonRow, off: &dyn Fn(&Sample) -> f64| {
            let squares: f64 = row.samples[1..].iter().map(off).sum();
            (squares / (row.samples.len() - 1) as f64).sqrt()
        };
        let gap = |s: &Sample| (s.nodes[0].R - exact(s.t)).norm_squared();
        let errors: Vec<f64> = rows.iter().map(|row| mean(row, &gap)).collect();
        assert_order(method, &errors, 2.0, 0.1);
        // ω goes round the same axis: its rate is a cross product with it.
        let gap = |s: &Sample| {
            let axis = Vector3::new(3.0, 0.0, 2.0);
            let omega = Rotation3::new(axis * s.t) * Vector3::new(3.0, 0.0, 4.0);
            (s.nodes[0].omega_dot - turned * axis.cross(&omega)).norm_squared()
        };
        let errors: Vec<f64> = rows.iter().map(|row| mean(row, &gap)).collect();
        assert_order(method, &errors, 2.0, 0.1);
        // The reference knows it as well.
        for (row, exact) in rows.iter().zip(errors) {
            let found = row.error.unwrap().of(ErrorQuantity::AngularAcceleration);
            let part = ((row.samples.len() - 1) as f64 / row.samples.len() as f64).sqrt();
            assert_close(found / (exact * part), 1.0, 0.01, method);
        }
    }
    for orders in &comparison.orders {
        for quantity in [ErrorQuantity::Rotation, ErrorQuantity::AngularAcceleration] {
            if let Some(order) = orders.of(quantity) {
                let name = &orders.scheme;
                assert!((order.order - 2.0).abs() < 0.1, "{name}: {order:?}");
            }
        }
    }
}

/// A rod on a ball joint with a body at its end, let go in a turn: rotations of frames and of a joint.
fn rod() -> String {
    let more = "[[loads]]\ngravity = [0, 0, -9.81]\n[analysis.dynamic]\nto = 0.5\nstep = 0.01\n";
    let body = body_of("tip", 0.5, "inertia = [0.05, 0.1, 0.15]");
    comparisons::rod("[2, 0, 5]", &(body + more))
}

#[test]
fn a_flexible_rod_moves_alike_in_every_formulation() {
    // The reference is the total formulation: others have its limit, at the order of their schemes.
    let methods = ["newmark", "ul-newmark", "lie-ga:0.8", "spin-newmark"];
    let comparison = compared(&rod(), &methods, &[0.008, 0.004, 0.002, 0.001]);
    for orders in &comparison.orders {
        for quantity in [
            ErrorQuantity::Position,
            ErrorQuantity::Rotation,
            ErrorQuantity::Velocity,
        ] {
            let order = orders.of(quantity).unwrap();
            let name = &orders.scheme;
            assert!((order.order - 2.0).abs() < 0.1, "{name}: {order:?}");
        }
    }
    // They are different methods.
    let error = |m: &str| comparison.of(m).last().unwrap().error.unwrap();
    let [total, updated, lie] =
        ["newmark", "ul-newmark", "spin-newmark"].map(|m| error(m).of(ErrorQuantity::Rotation));
    for (a, b) in [(total, updated), (total, lie), (updated, lie)] {
        assert!(
            (a - b).abs() > 1e-3 * a.max(b),
            "{total:e} {updated:e} {lie:e}"
        );
    }
}

#[test]
fn the_heavy_top_is_where_it_should_be_in_every_formulation() {
    let second = ["ul-newmark", "lie-ga:0.9", "spin-newmark"].map(|m| (m, 2));
    assert_heavy_top("", &second);
    assert_heavy_top("", &[("ul-radau", 3), ("wm-radau", 3)]);
}

#[test]
fn the_heavy_top_held_by_multipliers_is_where_it_should_be() {
    // Its foot is at the origin, where all rounding errors of the gap are of numbers that are zero.
    assert_heavy_top(HELD, &[("lie-ga:0.8", 2)]);
}

#[test]
fn the_tangent_of_spins_is_that_of_their_residual() {
    let file = input::parse("rod.toml", &rod()).unwrap();
    for formulation in [
        Formulation::Updated,
        Formulation::WienerMilenkovic,
        Formulation::LieGroup,
        Formulation::SpatialSpins,
        Formulation::MixedSpins,
    ] {
        let mut job = input::job("rod.toml", &file, Some(formulation)).unwrap();
        // A step centres the charts, and spins begin.
        let options = tight(Scheme::default(), 0.05, 0.01);
        let start = [&job.start.q[..], &job.start.v];
        let progress = observed(&mut job.context, start, &options, &mut |_, _| {});
        let mut state = check::TestState {
            t: progress.state.t,
            x: progress.state.q.into(),
            v: progress.state.v.into(),
            a: progress.state.a.into(),
        };
        for (k, x) in state.x.iter_mut().enumerate() {
            *x += 0.2 * (1.7 * k as f64).sin();
        }
        let states = [("between steps".to_owned(), state)];
        let report = check::system("rod", &mut job.context, &states);
        if [Formulation::Updated, Formulation::WienerMilenkovic].contains(&formulation) {
            report.assert();
            continue;
        }
        // Rows are those of θ, columns those of spins: M = Bᵀ M B T⁻¹, all derivatives of r exact.
        let failed: Vec<&str> = report.failures().iter().map(|r| &r.law[..]).collect();
        assert_eq!(failed, ["M symmetric"], "{report}");
    }
}

#[test]
fn a_model_whose_rotations_are_held_has_one_formulation() {
    let text = include_str!("../../../examples/models/pendulum.toml");
    let file = input::parse("pendulum.toml", text).unwrap();
    let refused = input::job("pendulum.toml", &file, Some(Formulation::LieGroup));
    let error = refused.err().unwrap().to_string();
    assert!(error.contains("without the prefix"), "{error}");
}

#[test]
fn words_that_no_formulation_takes_are_refused_by_name() {
    for (word, says) in [
        ("lie-radau", "one stage"),
        ("spin-ga:0.8", "newmark"),
        ("spin-bathe", "newmark"),
        ("ul-nothing", "ul-nothing"),
        ("lie-", "there are"),
    ] {
        let error = word.parse::<Method>().unwrap_err().to_string();
        assert!(error.contains(says) && error.contains(word), "{error}");
    }
}
