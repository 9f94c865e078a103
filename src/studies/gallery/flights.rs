//! Large motions in a plane: spin-up of an arm, and a beam thrown into the air.

use super::case::{CaseProblem, CaseReport, largest, with_step};
use super::motion::richardson;
use crate::output::plot::PlotCurve;
use pullback_elements::time::{SpinUp, TimeFunction};

/// D02: spin-up of a flexible arm.
pub(super) fn spin_up(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("spin_up")?;
    let Ok(spin_up) = SpinUp::new(6.0, 15.0) else {
        return Err(CaseProblem::Setup("its spin-up is not usable"));
    };
    // Time, extension and deflection in axes that turn with the hub.
    let seen = |step: f64| -> Result<Vec<[f64; 3]>, CaseProblem> {
        let run = report.motion(&with_step(&file, step), &["tip"])?;
        let states = run.t.iter().zip(&run.nodes[0]);
        let seen = states.map(|(&t, s)| {
            let (sin, cos) = spin_up.at(t, &[])[0].sin_cos();
            let [x, y] = [s.position.x, s.position.y];
            [t, cos * x + sin * y - 10.0, cos * y - sin * x]
        });
        Ok(seen.collect())
    };
    let (coarse, seen) = (seen(0.01)?, seen(0.005)?);
    let lowest = |seen: &[[f64; 3]], k: usize| {
        let best = seen.iter().min_by(|a, b| a[k].total_cmp(&b[k]));
        best.map_or([f64::NAN; 2], |s| [s[0], s[k]])
    };
    let source = "independent: spectral element in rotating axes, Radau, D02";
    for (k, name, [at, exact]) in [
        (2, "largest lag", [6.76, -0.5738345]),
        (1, "largest shortening", [6.74, -0.0188232]),
    ] {
        let [t, fine] = lowest(&seen, k);
        let [value] = richardson([lowest(&coarse, k)[1]], [fine]);
        report.compare(format!("{name}, extrapolated"), value, exact, 1e-5, source);
        report.compare(format!("{name}: time"), t, at, 0.01, source);
    }
    // The motion oscillates about the steady state: its mean counts.
    let steady: Vec<f64> = seen.iter().filter(|s| s[0] >= 16.0).map(|s| s[1]).collect();
    let mean = steady.iter().sum::<f64>() / steady.len() as f64;
    let source = "exact: L (tan x / x − 1), D02";
    report.compare("steady extension", mean, 5.143174550426e-4, 1e-5, source);
    let curve = |k: usize| seen.iter().map(|s| (s[0], s[k])).collect();
    report.figure(
        "Spin-up of a flexible arm",
        ["time t", "tip in axes of the hub"],
        vec![
            PlotCurve::new("extension", curve(1)),
            PlotCurve::new("deflection", curve(2)),
        ],
    )
}

/// D03: a flying flexible beam.
pub(super) fn flying(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("flying_beam")?;
    let run = report.motion(&with_step(&file, 0.01), &["loaded", "free"])?;
    let source = "independent: two codes agree to 5e-3, D03";
    for (t, exact) in [
        (1.0, [4.329, 0.4077, 0.3692, 7.7969]),
        (2.5, [4.9639, 4.4766, 3.5821, 6.1119]),
        (3.5, [7.3845, 7.0672, 7.8278, 5.0421]),
        (5.0, [9.784, 8.2026, 8.0748, 1.7581]),
    ] {
        let [a, b] = [0, 1].map(|k| run.at(k, t).position);
        for (name, computed, exact) in [
            ("loaded end e1", a.x, exact[0]),
            ("loaded end e3", a.z, exact[1]),
            ("free end e1", b.x, exact[2]),
            ("free end e3", b.z, exact[3]),
        ] {
            let what = format!("{name} at t = {t}");
            report.compare(what, computed, exact, 1e-2, source);
        }
    }
    let worst = largest(run.t.iter().zip(&run.balances).flat_map(|(t, balance)| {
        let momentum = balance.momentum.linear;
        [momentum.x - 8.0 * t.min(2.5), momentum.z]
    }));
    let source = "exact: impulse of the force";
    report.compare("momentum, largest error", worst, 0.0, 1e-9, source);
    report.figure(
        "Flying beam",
        ["along e1", "along e3"],
        vec![
            PlotCurve::new("loaded end", run.path(0, [0, 2])),
            PlotCurve::new("free end", run.path(1, [0, 2])),
        ],
    )
}
