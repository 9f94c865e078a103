//! Planar linkages of one degree of freedom. `tests/studies/mechanisms.rs` has the values with which they are compared.

use super::case::{CaseProblem, CaseReport, largest, with_step};
use super::motion::{History, richardson};
use crate::output::plot::PlotCurve;
use pullback_elements::model::NodeState;

/// Largest distance of two watched nodes.
pub(super) fn gap(run: &History, [a, b]: [usize; 2]) -> f64 {
    let both = run.nodes[a].iter().zip(&run.nodes[b]);
    largest(both.map(|(a, b)| (a.position - b.position).norm()))
}

pub(super) fn last(run: &History, node: usize) -> NodeState {
    run.nodes[node][run.nodes[node].len() - 1]
}

/// Position and velocity of the first of two watched nodes at the end, from steps of two sizes, and the motion in the
/// smaller ones.
fn motion(
    report: &CaseReport,
    model: &str,
    steps: [f64; 2],
    nodes: [&str; 2],
) -> Result<([[f64; 3]; 2], History), CaseProblem> {
    let file = report.model(model)?;
    let [coarse, fine] = report.motions(steps.map(|h| with_step(&file, h)), &nodes)?;
    let [[x, v], [finer_x, finer_v]] = [&coarse, &fine].map(|run| {
        let end = last(run, 0);
        [end.position.into(), end.velocity.into()]
    });
    Ok(([richardson(x, finer_x), richardson(v, finer_v)], fine))
}

const SOURCE: &str = "exact: closed-form kinematics, M θ̈ + ½ M′ θ̇² + V′ = 0 by Runge-Kutta";

/// A four-bar linkage of rigid bars.
pub(super) fn four_bar(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let nodes = ["coupler tip", "rocker tip"];
    let ([position, velocity], run) = motion(report, "four_bar", [1e-3, 5e-4], nodes)?;
    let what = "coupler tip at t = 4";
    let exact = [1.5714799768463528, 1.9414393135710721];
    report.compare_parts(what, &position, &exact, 1e-5, SOURCE);
    let exact = [-0.8259853769958346, -0.012133844159756178];
    report.compare_parts("its velocity", &velocity, &exact, 1e-4, SOURCE);
    let what = "largest gap of the loop in 8000 steps";
    report.compare_gap(what, gap(&run, [0, 1]), 1e-14);
    report.compare_energy(&run, 1e-4);
    report.figure(
        "Four-bar linkage: path of the coupler's tip",
        ["x", "y"],
        vec![PlotCurve::new("tip of the coupler", run.path(0, [0, 1]))],
    )
}

/// A slider-crank mechanism of rigid bars.
pub(super) fn slider_crank(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let nodes = ["slider", "rod end"];
    let ([[x, ..], [rate, ..]], run) = motion(report, "slider_crank", [1e-3, 5e-4], nodes)?;
    report.compare("slider at t = 2", x, 0.6468024755301318, 1e-5, SOURCE);
    report.compare("its velocity", rate, -1.3280708088685487, 1e-4, SOURCE);
    report.compare_gap("largest gap of the loop", gap(&run, [0, 1]), 1e-14);
    report.compare_energy(&run, 1e-3);
    Ok(())
}

/// Five parallelograms in a row.
///
/// All couplers only translate: a pendulum with the inertia of six cranks and the mass of five couplers at its end.
pub(super) fn parallelograms(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let nodes = ["end 5", "far 5"];
    let ([position, velocity], run) = motion(report, "parallelograms", [4e-3, 2e-3], nodes)?;
    let source = "exact: a pendulum, Runge-Kutta";
    let what = "last coupler at t = 4";
    let exact = [5.901471650279878, -0.43283814959136163];
    report.compare_parts(what, &position, &exact, 1e-5, source);
    let what = "its velocity along e1";
    report.compare(what, velocity[0], 0.5441331333714063, 1e-4, source);
    let source = "exact: the loops are closed at all times";
    let what = "largest gap of the last loop";
    report.compare(what, gap(&run, [0, 1]), 0.0, 2e-14, source);
    report.compare_energy(&run, 1e-4);
    Ok(())
}
