//! The laws of a scheme: its stated properties, measured on runs.
//!
//! | law | measured on |
//! |---|---|
//! | order | a nonlinear, driven motion with a known solution ([`KnownMotion`]): errors of position, velocity and acceleration at the end over the step |
//! | order under changes of chart | the same, with a change of chart every third step |
//! | order of the embedded method | the first motion by the scheme that ends its steps with the embedded row: one less than that of the scheme |
//! | exactness | a polynomial of the degree of the order; from order 2 on the velocity of a cubic, and its position up to the known error of the scheme |
//! | orders with multipliers | a mass held to a circle by a multiplier, with a known solution: errors of position, velocity, acceleration and multiplier at the end; or the refusal of multipliers by a scheme without damping at infinite frequencies |
//! | stability | Schur's and Cohn's conditions on the characteristic polynomial of a step (before a projection to its energy), from Ω = 10⁻³ to 10⁶ or to the stated limit |
//! | limit of stability | growth beyond the stated limit |
//! | time reversal | a conservative motion forth and back, if the scheme is declared symmetric |

mod multipliers;
mod problems;

use crate::Report;
use crate::vectors::larger;
use problems::{KnownMotion, OneCoordinate};
use pullback_integrators::dynamics::scheme::{SchemeProperties, Stage};
use pullback_integrators::dynamics::{
    DynamicOptions, DynamicsError, NewtonOptions, Progress, Scheme, Simulation, State, start,
};
use pullback_integrators::spectrum::{Numbers, amplification, characteristic, logarithmic};
use pullback_manifold::system::System;

/// Checks the stated properties of a scheme.
pub fn scheme(scheme: &Scheme) -> Report {
    let mut report = Report::new(scheme.to_string());
    order(&mut report, "order", scheme, false);
    order(&mut report, "order under changes of chart", scheme, true);
    if let Some(row) = scheme.embedded() {
        embedded(&mut report, scheme, *row);
    }
    exactness(&mut report, scheme);
    cubic(&mut report, scheme);
    stability(&mut report, scheme);
    multipliers::orders(&mut report, scheme);
    if scheme.properties().symmetric {
        reversal(&mut report, scheme);
    }
    report
}

/// Adds a computed defect, or why it cannot be computed.
fn defect(
    report: &mut Report,
    law: &str,
    at: &str,
    found: Result<f64, DynamicsError>,
    allowed: f64,
) {
    match found {
        Ok(defect) => report.defect(law, at, defect, allowed),
        Err(error) => report.impossible(law, at, error.to_string()),
    }
}

/// Relative error to which the equations of a step are solved.
const SOLVED: f64 = 1e-13;
/// Errors below those of 240 steps with equations solved to this are round-off.
const ROUNDING: f64 = 240.0 * SOLVED;

/// A run in equal steps.
fn run<Y: System>(
    system: &mut Y,
    scheme: &Scheme,
    progress: &mut Progress,
    to: f64,
    steps: usize,
) -> Result<(), DynamicsError> {
    let options = DynamicOptions {
        scheme: *scheme,
        newton: NewtonOptions {
            relative: SOLVED,
            ..NewtonOptions::default()
        },
        ..DynamicOptions::new(to, (to - progress.state.t) / steps as f64)
    };
    let mut run = Simulation::resume(system, progress.clone(), &options)?;
    let outcome = run.finish();
    progress.clone_from(run.progress());
    outcome
}

/// Errors of position, velocity and acceleration at the end of the known motion.
fn errors(scheme: &Scheme, steps: usize, switching: bool) -> Result<[f64; 3], DynamicsError> {
    let end = 1.5;
    let mut system = KnownMotion::new(switching);
    let [x, v, _] = KnownMotion::motion(0.0);
    let mut progress = Progress::new(start(&system, 0.0, &x, &v)?);
    run(&mut system, scheme, &mut progress, end, steps)?;
    let State { q, v, a, .. } = &progress.state;
    let found = system.position([q, v, a]);
    let exact = KnownMotion::motion(end);
    let gap = |k: usize| (0..2).map(move |i| (found[k][i] - exact[k][i]).abs());
    Ok([0, 1, 2].map(|k| gap(k).fold(0.0, f64::max)))
}

/// The order of the method that ends the steps of a scheme with its embedded row.
fn embedded(report: &mut Report, scheme: &Scheme, row: Stage) {
    let law = "order of the embedded method";
    let rows = [&scheme.stages()[..scheme.stages().len() - 1], &[row]].concat();
    let properties = SchemeProperties {
        order: scheme.order().saturating_sub(1),
        ..scheme.properties()
    };
    match Scheme::new("embedded", &rows, properties) {
        Ok(method) => order(report, law, &method, false),
        Err(error) => report.impossible(law, "its table", error.to_string()),
    }
}

fn order(report: &mut Report, law: &str, scheme: &Scheme, switching: bool) {
    let runs = [15, 30, 60, 120, 240].map(|steps| errors(scheme, steps, switching));
    let runs: Vec<[f64; 3]> = match runs.into_iter().collect() {
        Ok(runs) => runs,
        Err(error) => return report.impossible(law, "a known motion", error.to_string()),
    };
    for (k, what) in ["position", "velocity", "acceleration"].iter().enumerate() {
        // The shortest steps, for the order of inaccurate schemes, whose errors are above rounding, for accurate ones.
        let mut pairs = runs.windows(2).rev().map(|pair| [pair[0][k], pair[1][k]]);
        let finest = pairs.find(|[_, fine]| *fine > ROUNDING || fine.is_nan());
        let slope = finest.map_or(f64::NAN, |[coarse, fine]| (coarse / fine).log2());
        report.rate(law, what, slope, scheme.order() as f64);
    }
}

fn exactness(report: &mut Report, scheme: &Scheme) {
    let degree = scheme.order().min(OneCoordinate::DEGREE);
    let at = ["a line", "a parabola", "a cubic", "a quartic"][degree.clamp(1, 4) - 1];
    let mut system = OneCoordinate::polynomial(degree);
    let [q, v] = system.motion(0.0);
    let run = start(&system, 0.0, &[q], &[v]).and_then(|state| {
        let mut progress = Progress::new(state);
        run(&mut system, scheme, &mut progress, 2.0, 10)?;
        let (state, [q, v]) = (progress.state, system.motion(2.0));
        Ok((state.q[0] - q).abs().max((state.v[0] - v).abs()))
    });
    defect(report, "exactness", at, run, 1e-12);
}

/// A cubic, whose accelerations are linear in time: schemes of order 2 and more integrate its velocity exactly, and the
/// error of its position is the same multiple of h³ in every step.
fn cubic(report: &mut Report, scheme: &Scheme) {
    if scheme.order() < 2 {
        return;
    }
    let mut system = OneCoordinate::polynomial(3);
    let [q, v] = system.motion(0.0);
    let (to, steps) = (2.0, 10_u32);
    let h = to / f64::from(steps);
    let late = system.acceleration(scheme.lateness() * h);
    let run = start(&system, 0.0, &[q], &[v]).and_then(|state| {
        // Accelerations at the start first.
        let begin = DynamicOptions {
            scheme: *scheme,
            ..DynamicOptions::new(0.0, h)
        };
        let first = Simulation::new(&mut system, state, &begin)?;
        let mut progress = first.progress().clone();
        progress.state.algorithmic[0] = late;
        run(&mut system, scheme, &mut progress, to, steps as usize)?;
        let jerk = system.acceleration(1.0) - system.acceleration(0.0);
        let own = f64::from(steps) * scheme.cubic_error() * h.powi(3) * jerk;
        let (state, [q, v]) = (progress.state, system.motion(to));
        Ok((state.q[0] - own - q).abs().max((state.v[0] - v).abs()))
    });
    defect(report, "exactness", "a cubic", run, 1e-12);
}

/// The largest violation of Schur's and Cohn's conditions for roots of λ³ + p₁ λ² + p₂ λ + p₃ in the unit circle.
fn outside([p1, p2, p3]: [f64; 3]) -> f64 {
    let missed = [
        -(1.0 + p1 + p2 + p3),
        -(1.0 - p1 + p2 - p3),
        p3.abs() - 1.0,
        p3 * p3 - 1.0 + (p2 - p1 * p3).abs(),
    ];
    missed.into_iter().fold(0.0, larger)
}

fn stability(report: &mut Report, scheme: &Scheme) {
    let law = "stability";
    let limit = scheme.properties().limit;
    let last = limit.map_or(1e6, |limit| limit * (1.0 - 1e-6));
    let (mut worst, mut position) = (0.0, 1e-3);
    for Omega in logarithmic(1e-3, last, 91) {
        match amplification(scheme, Omega) {
            Ok(A) => {
                let defect = outside(characteristic(A));
                if defect > worst || defect.is_nan() {
                    (worst, position) = (defect, Omega);
                }
            }
            Err(error) => {
                return report.impossible(law, &format!("Ω = {Omega}"), error.to_string());
            }
        }
    }
    report.defect(law, &format!("Ω = {position:.3e}"), worst, 1e-12);
    let Some(limit) = limit else { return };
    let (law, Omega) = ("limit of stability", 1.001 * limit);
    let at = format!("Ω = {Omega:.4}");
    match amplification(scheme, Omega) {
        Ok(A) => {
            let radius = Numbers::of(characteristic(A), Omega).radius;
            // A scheme that is bounded here has a larger limit.
            report.defect(law, &at, 1.0 + 1e-12, radius);
        }
        Err(error) => report.impossible(law, &at, error.to_string()),
    }
}

fn reversal(report: &mut Report, scheme: &Scheme) {
    let state = [[0.7, -0.2], [0.5, 0.9]];
    let run = || -> Result<f64, DynamicsError> {
        let mut system = KnownMotion::alone();
        let mut progress = Progress::new(start(&system, 0.0, &state[0], &state[1])?);
        run(&mut system, scheme, &mut progress, 2.0, 40)?;
        progress.state.v.iter_mut().for_each(|v| *v = -*v);
        run(&mut system, scheme, &mut progress, 4.0, 40)?;
        let positions = progress.state.q.iter().zip(state[0]);
        let rates = progress.state.v.iter().zip(state[1]);
        let gaps = positions
            .map(|(q, x)| q - x)
            .chain(rates.map(|(v, x)| v + x));
        Ok(gaps.fold(0.0_f64, |m, gap| m.max(gap.abs())))
    };
    let at = "40 steps forth and back";
    defect(report, "time reversal", at, run(), 1e-10);
}
