//! Critical loads by linear extrapolation against exact solutions.
#![allow(clippy::unwrap_used, non_snake_case)]

use super::assert_near;
use crate::support::beams::{COLUMN, PINNED, line};
use pullback::input::{Plan, assemble_text};
use pullback::integrators::linearization::{BucklingError, BucklingMode, buckling};
use pullback::integrators::statics::{
    CriticalKind, StaticNewtonOptions, critical_point, equilibrium,
};
use pullback::manifold::system::Point;
use std::f64::consts::PI;

/// Critical loads of a model file from its state at load parameter `from`.
fn critical(text: &str, from: f64, count: usize) -> Result<Vec<BucklingMode>, BucklingError> {
    let mut job = assemble_text("model.toml", text).unwrap();
    let mut q = vec![0.0; job.context.initial().len()];
    if let (Plan::Static(options), true) = (&mut job.plan, from > 0.0) {
        options.to = from;
        q = equilibrium(&mut job.context, options).unwrap();
    }
    buckling(&mut job.context, Point::statics(from, &q), count)
}

/// Finds the critical point of a mode directly, from nine tenths of its load: the same where the path is straight.
fn assert_direct(text: &str, mode: &BucklingMode, tolerance: f64) {
    let mut job = assemble_text("model.toml", text).unwrap();
    let Plan::Static(options) = &mut job.plan else {
        unreachable!()
    };
    options.to = 0.9 * mode.load;
    let q = equilibrium(&mut job.context, options).unwrap();
    let at = Point::statics(options.to, &q);
    let newton = StaticNewtonOptions::default();
    let point = critical_point(&mut job.context, at, Some(&mode.shape), &newton).unwrap();
    assert_eq!(point.kind, CriticalKind::Bifurcation);
    assert_near(point.t, mode.load, tolerance);
    let corrections = &point.corrections;
    // Below, rounding errors of stiffnesses that differ by eight powers of ten.
    let large = corrections.iter().take_while(|c| **c > 1e-6).count();
    assert!(large <= 4, "{corrections:?}");
    assert!(corrections[2] < corrections[1].powf(1.5), "{corrections:?}");
}

/// With EA = GA the equation of a pinned column is EI φ″ + P φ = 0; elements of order one make its critical loads
/// 4 EI/h² tan²(kπh/2L).
#[test]
fn a_pinned_column_in_both_planes() {
    let n = 16.0;
    let load = |EI: f64, k: f64| 4.0 * EI * n * n * (k * PI / (2.0 * n)).tan().powi(2);
    let exact = [load(1.0, 1.0), load(3.0, 1.0), load(1.0, 2.0)];
    for from in [0.0, 5.0] {
        let found = critical(&line(COLUMN, 16, 1, PINNED), from, 3).unwrap();
        for (mode, exact) in found.iter().zip(exact) {
            assert_near(mode.load, exact, 1e-6);
        }
    }
    let text = line(COLUMN, 16, 1, PINNED);
    for mode in critical(&text, 0.0, 3).unwrap() {
        assert_direct(&text, &mode, 1e-9);
    }
    let beyond = critical(&line(COLUMN, 16, 1, PINNED), 12.0, 1);
    assert_eq!(beyond, Err(BucklingError::Unstable));
}

const CLAMPED: &str = "[[supports]]\nnode = \"A\"\nfix = \"all\"\n";

/// P L²/√(EI GJ) of a narrow cantilever with a force at its tip, across the plane of its large stiffness.
#[test]
fn lateral_buckling_of_a_cantilever() {
    let load = format!("{CLAMPED}[[loads]]\nnode = \"B\"\nforce = [0, 0, -1]\n");
    let stiffness = "EA = 1e8, GA = [1e8, 1e8], GJ = 0.25, EI = [1e7, 1.0]";
    let found = critical(&line(stiffness, 12, 3, &load), 0.0, 2).unwrap();
    for mode in found {
        assert_near(mode.load.abs(), 4.012599343578901 * 0.5, 1e-5);
        assert_direct(&line(stiffness, 12, 3, &load), &mode, 1e-6);
    }
}

/// q L³/EI of a column under its own weight.
#[test]
fn a_column_under_its_own_weight() {
    let load = format!("{CLAMPED}[[loads]]\nline = \"line\"\nforce_per_length = [-1, 0, 0]\n");
    let stiffness = "EA = 1e7, GA = [1e7, 1e7], GJ = 1.0, EI = [1.0, 2.0]";
    let found = critical(&line(stiffness, 12, 3, &load), 0.0, 2).unwrap();
    assert_near(found[0].load, 7.837347438943484, 1e-5);
    assert_near(found[1].load, 2.0 * 7.837347438943484, 1e-5);
    for mode in &found {
        assert_direct(&line(stiffness, 12, 3, &load), mode, 1e-6);
    }
}

#[test]
fn follower_loads_are_refused() {
    let load = format!("{CLAMPED}[[loads]]\nnode = \"B\"\nforce = [0, 0, -1]\nfollower = true\n");
    let stiffness = "EA = 1e4, GA = [1e4, 1e4], GJ = 1.0, EI = [1.0, 1.0]";
    // Without a load as well, where the tangent is still symmetric.
    for from in [0.0, 0.5] {
        let refused = critical(&line(stiffness, 4, 1, &load), from, 1);
        assert_eq!(refused, Err(BucklingError::Asymmetric));
    }
}

#[test]
fn loads_that_do_not_grow_are_refused() {
    let constant = "[[loads]]\nnode = \"B\"\nforce = [0, 0, -1]\ntime = { constant = 1 }\n";
    let stiffness = "EA = 1e4, GA = [1e4, 1e4], GJ = 1.0, EI = [1.0, 1.0]";
    for (load, from) in [("", 0.0), (constant, 0.5)] {
        let refused = critical(&line(stiffness, 4, 1, &format!("{CLAMPED}{load}")), from, 1);
        assert_eq!(refused, Err(BucklingError::NoLoad));
    }
}

/// A straight column keeps its shape until it buckles; Lee's frame bends from the start, and snaps at 18546.558 of 20000
/// (independent shooting).
#[test]
fn the_error_tells_a_poor_estimate() {
    let load = format!("{CLAMPED}[[loads]]\nnode = \"B\"\nforce = [-1, 0, 0]\n");
    let stiffness = "EA = 1e5, GA = [1e5, 1e5], GJ = 1.0, EI = [1.0, 2.0]";
    let column = critical(&line(stiffness, 8, 1, &load), 0.0, 1).unwrap();
    assert!(column[0].error < 1e-3, "{column:?}");
    let frame = std::fs::read_to_string("examples/models/lee_frame.toml").unwrap();
    let frame = critical(&frame, 0.0, 1).unwrap();
    let off = (frame[0].load / (18546.558 / 20000.0) - 1.0).abs();
    assert!(off > 0.1 && frame[0].error > 0.1, "{frame:?}");
}
