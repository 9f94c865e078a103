//! The heavy top in the formulations of rotations, and their tangents.

use crate::support::closures::body_of;
use crate::support::comparisons;
use crate::support::dynamics::{formulated, observed, tight};
use crate::support::heavy_top::assert_heavy_top;
use crate::support::prelude::*;
use pullback::conformance as check;

/// A rod on a ball joint with a body at its end, let go in a turn: rotations of frames and of a joint.
fn rod() -> String {
    let more = "[[loads]]\ngravity = [0, 0, -9.81]\n[analysis.dynamic]\nto = 0.5\nstep = 0.01\n";
    let body = body_of("tip", 0.5, "inertia = [0.05, 0.1, 0.15]");
    comparisons::rod("[2, 0, 5]", &(body + more))
}

#[test]
fn the_heavy_top_is_where_it_should_be_in_every_formulation() {
    let second = ["ul-newmark", "lie-ga:0.9", "spin-newmark"].map(|m| (m, 2));
    let third = ["ul-radau", "wm-radau"].map(|m| (m, 3));
    assert_heavy_top("", &[&second[..], &third].concat());
}

#[test]
fn the_tangent_of_spins_is_that_of_their_residual() {
    for formulation in [
        Formulation::Updated,
        Formulation::WienerMilenkovic,
        Formulation::LieGroup,
        Formulation::SpatialSpins,
        Formulation::MixedSpins,
    ] {
        let mut job = formulated(&rod(), formulation);
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
