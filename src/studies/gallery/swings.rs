//! Pendulums: rigid, of two flexible rods, and of rubber.

use super::case::{CaseProblem, CaseReport, largest, until, with_step};
use super::exact::first_kind;
use super::motion::{History, observed_order, richardson};
use crate::output::plot::PlotCurve;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Order in the step of the position of a node at t = 0.5, with gravity applied smoothly until then: a sudden start
/// excites waves that no practical step resolves, and hides the order.
fn order(report: &mut CaseReport, model: &str, node: &str) -> Result<(), CaseProblem> {
    let rise = format!(
        "{{ sine = {{ amplitude = 0.5, omega = {TAU}, phase = {}, offset = 0.5 }} }}",
        -FRAC_PI_2
    );
    let file = report.model_with(model, &[("loads.0.time", &rise)])?;
    let files = [2e-3, 1e-3, 5e-4].map(|h| until(&file, h, 0.5));
    let runs = report.motions(files, &[node])?;
    let ends = runs.map(|run| run.at(0, 0.5).position);
    let what = "order in the step, gravity put on smoothly";
    report.compare_order(what, observed_order(&ends), 0.1);
    Ok(())
}

/// R04: a pendulum released from the horizontal, and one struck so that it turns over.
pub(super) fn pendulum(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("pendulum")?;
    let [a, b, c] = report.motions([4e-3, 2e-3, 1e-3].map(|h| with_step(&file, h)), &["rod"])?;
    let source = "exact: elliptic functions, R04";
    for (t, exact) in [
        (1.0, [0.986291751131875, -0.165010853125541]),
        (5.0, [-0.942305435043757, -0.334754338414001]),
        (10.0, [-0.275087462576117, -0.961419205099125]),
    ] {
        let position = |h: &History| {
            let position = h.at(0, t).position;
            [position.x, position.z]
        };
        let computed = richardson(position(&b), position(&c));
        for (k, name) in ["e1", "e3"].into_iter().enumerate() {
            let what = format!("extrapolated position at t = {t} along {name}");
            report.compare(what, computed[k], exact[k], 1e-6, source);
        }
    }
    let ends = [&a, &b, &c].map(|h| h.at(0, 10.0).position);
    report.compare_order("order in the step", observed_order(&ends), 0.05);
    let error = c.energy_error();
    report.compare("energy error", error, 0.0, 1e-5, "conserved");
    over(report)
}

/// Angle of a pendulum from its lowest position, whole turns included.
fn turned(run: &History) -> Vec<f64> {
    let mut turned = 0.0;
    let angles = run.nodes[0].iter().map(|s| {
        let angle = s.position.x.atan2(-s.position.z);
        turned += (angle - turned + PI).rem_euclid(TAU) - PI;
        turned
    });
    angles.collect()
}

/// The same pendulum, struck at its lowest position so that it turns over: θ̇(0) = ω = 8.
///
/// Energy says θ̇² = ω² − (4g/l) sin²(θ/2), so that a turn takes
/// (2/ω) ∫₀^π dφ/√(1 − k² sin²φ) = 4 K(k)/ω with k = 2√(g/l)/ω, and half a turn half of that.
fn over(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let (omega, g_over_l) = (8.0, 9.81);
    let turn = 4.0 * first_kind(FRAC_PI_2, 4.0 * g_over_l / (omega * omega)) / omega;
    let struck = [("joints.0.rate", "8"), ("joints.1.position", "[0, 0, -1]")];
    let file = report.model_with("pendulum", &struck)?;
    let run = |count: usize| {
        let file = until(&file, turn / count as f64, 6.0 * turn);
        report.motion(&file, &["rod"])
    };
    let [coarse, fine] = [(500, run(500)?), (1000, run(1000)?)];
    let source = "exact: elliptic integral, R04 struck so that it goes over";
    // At half turns, which are passed with the least and the largest speed.
    for halves in [2, 7, 12] {
        let [a, b] = [&coarse, &fine].map(|(count, run)| {
            let k = halves * count / 2;
            [turned(run)[k] / TAU, run.nodes[0][k].velocity.norm()]
        });
        let [turns, speed] = richardson(a, b);
        let exact = halves as f64 / 2.0;
        let at = format!("after {exact} periods of going over");
        report.compare(format!("turns {at}"), turns, exact, 1e-6, source);
        let rise = if halves % 2 == 0 { 0.0 } else { 4.0 * g_over_l };
        let exact = f64::sqrt(omega * omega - rise);
        report.compare(format!("speed {at}"), speed, exact, 1e-6, source);
    }
    Ok(())
}

/// A double pendulum of flexible rods.
pub(super) fn double(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("double_pendulum")?;
    order(report, "double_pendulum", "tip")?;
    let files = [2e-3, 1e-3, 5e-4].map(|h| with_step(&file, h));
    let [a, b, c] = report.motions(files, &["tip", "knee"])?;
    let order = (a.energy_error() / b.energy_error()).log2();
    report.compare_order("order of the energy error", order, 0.1);
    report.compare("energy error", c.energy_error(), 0.0, 1e-4, "conserved");
    // The hinges keep the motion in its plane.
    let across = largest(c.nodes[0].iter().map(|s| s.d.y));
    report.compare("out of the plane", across, 0.0, 1e-9, "symmetry");
    report.figure(
        "Flexible double pendulum",
        ["along e1", "along e3"],
        vec![
            PlotCurve::new("knee", c.path(1, [0, 2])),
            PlotCurve::new("tip", c.path(0, [0, 2])),
        ],
    )
}

/// A rubber rod that swings under its own weight.
pub(super) fn rubber(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("rubber_rod")?;
    let c = report.motion(&with_step(&file, 5e-4), &["end"])?;
    report.compare("energy error", c.energy_error(), 0.0, 1e-4, "conserved");
    order(report, "rubber_rod", "end")?;
    let files = [8, 16].map(|elements| {
        let mut file = until(&file, 1e-3, 0.5);
        file.lines[0].elements = elements;
        file
    });
    let [coarse, fine] = (report.motions(files, &["end"])?).map(|run| run.at(0, 0.5).position);
    let mesh = (coarse - fine).norm();
    let what = "8 and 16 quadratic elements apart at t = 0.5";
    report.compare(what, mesh, 0.0, 1e-3, "convergence with the mesh");
    report.figure(
        "Swinging rubber rod",
        ["along e1", "along e3"],
        vec![PlotCurve::new("path of the end", c.path(0, [0, 2]))],
    )
}
