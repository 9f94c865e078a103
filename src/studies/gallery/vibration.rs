//! Modes over the speed of a rotation.

use super::case::{CaseProblem, CaseReport};
use crate::input::{self, EigenvaluePlan};
use crate::output::plot::PlotCurve;
use pullback_integrators::linearization::{Mode, campbell};
use std::ops::ControlFlow;

/// Flap μ of a clamped blade without hub, w⁗ − Ω² (T w′)′ = μ² w with T = (1 − x²)/2, over its speed; lag is
/// √(μ² − Ω²).
const FLAP: [(f64, [f64; 2]); 3] = [
    (0.0, [3.516015268500151, 22.03449156466677]),
    (2.0, [4.13731957303, 22.6149219565]),
    (6.0, [7.360373019310019, 26.8090816785]),
];
const SOURCE: &str = "published: Wright et al. 1982; power series";

fn lag(speed: f64, flap: [f64; 2]) -> [f64; 2] {
    flap.map(|mu| (mu * mu - speed * speed).sqrt())
}

/// A rotating blade.
pub(super) fn blade(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("rotating_blade")?;
    let mut job = input::job(report.case, &file, None).map_err(Box::new)?;
    let Some(EigenvaluePlan::Campbell(input, options)) = &job.eigenvalues else {
        return Err(CaseProblem::Setup("it has no speeds"));
    };
    let mut go_on = |_| ControlFlow::Continue(());
    let diagram = campbell(
        &mut job.context,
        *input,
        &mut job.start.q,
        options,
        &mut go_on,
    )?;
    for (speed, flap) in FLAP {
        let row = diagram.speeds.iter().position(|x| *x == speed);
        let row = row.ok_or(CaseProblem::Setup("a speed is missing"))?;
        let modes = diagram.lines.iter().take(4);
        let mut found: Vec<f64> = modes
            .map(|line| line[row].as_ref().map_or(f64::NAN, Mode::omega))
            .collect();
        found.sort_by(f64::total_cmp);
        let [lag_1, lag_2] = lag(speed, flap);
        let names = ["lag 1", "flap 1", "lag 2", "flap 2"];
        let exact = [lag_1, flap[0], lag_2, flap[1]];
        for ((name, found), exact) in names.into_iter().zip(found).zip(exact) {
            let quantity = format!("{name} at speed {speed}");
            report.compare(quantity, found, exact, 1e-6 * exact, SOURCE);
        }
    }
    let curve = |(k, line): (usize, &Vec<Option<Mode>>)| {
        let modes = diagram.speeds.iter().zip(line);
        let points = modes.filter_map(|(speed, mode)| Some((*speed, mode.as_ref()?.omega())));
        PlotCurve::new(format!("mode {}", k + 1), points.collect())
    };
    let lines = diagram.lines.iter().take(4).enumerate();
    let exact = FLAP.iter().flat_map(|(speed, flap)| {
        let all = lag(*speed, *flap).into_iter().chain(*flap);
        all.map(|omega| (*speed, omega))
    });
    let series = PlotCurve::points("power series", exact.collect());
    report.figure(
        "A rotating blade",
        [
            "speed Ω, in √(EI/Aρ)/L²",
            "circular frequency, in √(EI/Aρ)/L²",
        ],
        lines.map(curve).chain([series]).collect(),
    )
}
