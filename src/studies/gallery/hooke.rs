//! Hooke's joint: two shafts and a cross between them.

use super::case::{CaseProblem, CaseReport, largest, with_scheme, with_step};
use super::motion::{History, continued, richardson};
use crate::input::ModelFile;
use crate::output::plot::PlotCurve;
use nalgebra::Vector3;
use pullback_elements::model::NodeState;
use std::f64::consts::PI;

/// Lead of the output over the input, tan β = tan α / cos γ for shafts at an angle γ.
fn ahead(alpha: f64, cosine: f64) -> f64 {
    let (s, c) = alpha.sin_cos();
    (s * c * (1.0 / cosine - 1.0)).atan2(c * c + s * s / cosine)
}

/// Rotation angle of a node over time, any number of turns.
fn angles(states: &[NodeState]) -> Vec<f64> {
    continued(states).iter().map(Vector3::norm).collect()
}

/// Case 4 of [M04]. Its plot redraws Fig. 35.
pub(super) fn hooke(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("hooke")?;
    let cosine = 0.5_f64.sqrt();
    let run = report.motion(&file, &["A", "B"])?;
    let [a, b] = [0, 1].map(|k| angles(&run.nodes[k]));
    let difference: Vec<f64> = a.iter().zip(&b).map(|(a, b)| b - a).collect();
    let exact: Vec<f64> = a.iter().map(|&a| ahead(a, cosine)).collect();
    let late = (run.t.iter().zip(difference.iter().zip(&exact))).filter(|(t, _)| **t > 1.0);
    let worst = largest(late.map(|(_, (d, e))| d - e));
    let source = "exact: tan β = tan α / cos 45°";
    report.compare("largest error after the moment", worst, 0.0, 1e-3, source);
    let amplitude = largest(difference.iter().copied());
    let most = ((1.0 - cosine) / (1.0 + cosine)).asin();
    report.compare("amplitude", amplitude, most, 1e-3, source);
    // `tests/studies/mechanisms.rs`
    let source = "independent: rigid shafts, Runge-Kutta";
    let last = a.last().copied().unwrap_or(f64::NAN);
    let what = "angle of the input at t = 30";
    report.compare(what, last, 12.058148856657146, 1e-3, source);
    let curve = |values: &[f64]| -> Vec<(f64, f64)> {
        run.t.iter().copied().zip(values.iter().copied()).collect()
    };
    report.figure(
        "Hooke's joint",
        ["time t", "‖Ψ_B‖ − ‖Ψ_A‖ (rad)"],
        vec![
            PlotCurve::new("two beams, two revolute joints", curve(&difference)),
            PlotCurve::points("exact", curve(&exact).into_iter().step_by(12).collect()),
        ],
    )
}

/// Steps of the universal joint: half a degree once the input has the speed 1, after a spin-up by ten
/// degrees. All angles of R08 are then those of steps.
const STEP: f64 = PI / 360.0;
const SPIN_UP: usize = 40;

/// The input shaft spins up to a constant speed and makes a whole turn; the shafts are stiff and light.
fn light(report: &CaseReport, degrees: f64) -> Result<ModelFile, CaseProblem> {
    let (s, c) = degrees.to_radians().sin_cos();
    let turn = format!(
        "{{ spin_up = {{ rate = 1, duration = {} }} }}",
        SPIN_UP as f64 * STEP
    );
    let end = ((SPIN_UP / 2 + 720) as f64 * STEP).to_string();
    let values = [
        ("nodes.B", &*format!("[{c}, {s}, 0]")),
        ("sections.shaft.stiffness.GA", "[1e7, 1e7]"),
        ("sections.shaft.mass.J", "[2e-3, 1e-3, 1e-3]"),
        ("loads", "[]"),
        ("supports.0.fix", r#"["x", "y", "z", "ry", "rz"]"#),
        ("supports.0.prescribed", &format!("{{ rx = {turn} }}")),
        ("analysis.dynamic.to", &end),
    ];
    Ok(with_scheme(&report.model_with("hooke", &values)?, "ga:0.5"))
}

/// Angles of input and output and the ratio of their speeds at all steps.
fn turned(run: &History) -> Vec<[f64; 3]> {
    let [a, b] = [0, 1].map(|k| angles(&run.nodes[k]));
    let states = run.nodes[0].iter().zip(&run.nodes[1]);
    (states.zip(a.into_iter().zip(b)))
        .map(|((i, o), (a, b))| [a, b, o.omega.norm() / i.omega.norm()])
        .collect()
}

/// R08: the kinematics alone.
pub(super) fn universal(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let source = "exact: R08, angles from where the input yoke lies in the plane";
    let at_30 = [
        (0, 0.0, 1.15470053838),
        (30, 33.690067526, 1.06587742004),
        (45, 49.1066053509, 0.989743318611),
        (90, 90.0, 0.866025403784),
    ];
    let at_45 = [(60, 67.7923457014, 0.808122035642)];
    for (degrees, points) in [(30.0, &at_30[..]), (45.0, &at_45)] {
        let file = light(report, degrees)?;
        let files = [STEP, 0.5 * STEP].map(|h| with_step(&file, h));
        let [coarse, fine] = report.motions(files, &["A", "B"])?;
        let (coarse, fine) = (turned(&coarse), turned(&fine));
        let both = coarse.into_iter().zip(fine.into_iter().step_by(2));
        let rows: Vec<[f64; 3]> = both.map(|(c, f)| richardson(c, f)).collect();
        let (s, c) = degrees.to_radians().sin_cos();
        // The scheme halves in every step the disturbance of the speeds at the end of the spin-up.
        let settled = 2 * SPIN_UP;
        let relation = largest(rows.iter().map(|[a, b, _]| b - a - ahead(*a, c)));
        let speeds = largest(
            (rows.iter().skip(settled))
                .map(|[a, _, ratio]| ratio - c / (1.0 - (s * a.cos()).powi(2))),
        );
        let shafts = format!("shafts at {degrees}°");
        let what = format!("{shafts}: output off the relation, at most");
        report.compare(what, relation, 0.0, 1e-7, "exact: tan β = tan α / cos γ");
        let what = format!("{shafts}: ratio of speeds off the relation, at most");
        let formula = "exact: cos γ / (1 − sin² γ cos² α)";
        report.compare(what, speeds, 0.0, 1e-7, formula);
        for &(alpha, beta, speed) in points {
            // The relation repeats itself after half a turn.
            let [_, b, ratio] = rows[SPIN_UP / 2 + 2 * (180 + alpha)];
            let at = format!("{shafts}, input {alpha}°");
            let what = format!("output (degrees) of {at}");
            report.compare(what, b.to_degrees() - 180.0, beta, 1e-5, source);
            let what = format!("ratio of speeds of {at}");
            report.compare(what, ratio, speed, 1e-7, source);
        }
    }
    Ok(())
}
