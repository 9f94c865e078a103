//! Figures of spectra.

use super::{Number, RESOLVED, Spectrum, SpectrumPoint};
use crate::output::plot::{AxisScale, Graph, PlotCurve, PlotError, graphs};
use pullback_integrators::dynamics::Scheme;
use pullback_integrators::spectrum as integrator;

const TITLE: &str = "Lines: closed forms; marks: measured in steps";

const LINEAR: AxisScale = AxisScale::Linear;
const LOG: AxisScale = AxisScale::Logarithmic;

/// Figures by their file names: spectra, and the overshoot of the first step.
///
/// # Errors
/// [`PlotError`] of the drawing library.
pub fn figures(spectra: &[(Scheme, Spectrum)]) -> Result<[(&'static str, String); 2], PlotError> {
    let title = format!("{TITLE}; broken: κ Ω² and σ Ω³ of theory");
    let accuracy = graphs(Some(&title), "", &accuracy(spectra))?;
    let overshoot = overshoot(spectra);
    let overshoot = graphs(Some(TITLE), "largest value of exact motion", &overshoot)?;
    Ok([("spectrum.svg", accuracy), ("overshoot.svg", overshoot)])
}

/// A number of all schemes over Ω up to `to`.
fn graph(
    spectra: &[(Scheme, Spectrum)],
    y: &str,
    scale: [AxisScale; 2],
    to: f64,
    number: Number,
) -> Graph {
    let mut curves = Vec::new();
    for (k, (_, s)) in spectra.iter().enumerate() {
        let inside = || s.points.iter().filter(|p| p.steps.Omega <= to);
        let at = |p: &integrator::Accuracy| Some((p.Omega, number(p)?));
        let steps: Vec<_> = inside().filter_map(|p| at(&p.steps)).collect();
        let closed: Vec<_> = inside().filter_map(|p| at(p.closed.as_ref()?)).collect();
        let marks = marks(&steps, scale[0], k as f64 / spectra.len() as f64);
        let line = if closed.is_empty() { steps } else { closed };
        curves.push(PlotCurve::new(s.scheme.clone(), line).colored(k));
        curves.push(PlotCurve::points(s.scheme.clone(), marks).colored(k));
    }
    Graph::new(["Ω = ω h".to_owned(), y.to_owned()], scale, curves)
}

/// Spectral radius, damping ratio and period elongation.
fn accuracy(spectra: &[(Scheme, Spectrum)]) -> Vec<Graph> {
    let graph = |y, scale, to, number| graph(spectra, y, scale, to, number);
    // Growth is shown in part only.
    let radius: Number = |p| Some(p.numbers.radius).filter(|r| *r <= HIGHEST);
    let elongation = "period elongation";
    let mut out = vec![
        graph("spectral radius", [LOG, LINEAR], f64::INFINITY, radius),
        graph("damping ratio", [LINEAR; 2], RESOLVED, |p| {
            p.numbers.damping
        }),
        graph(elongation, [LINEAR; 2], RESOLVED, |p| p.numbers.elongation),
        graph("|period elongation|", [LOG; 2], RESOLVED, |p| {
            p.numbers.elongation.map(f64::abs)
        }),
        // Rounding errors of a scheme without damping have no logarithm.
        graph("damping ratio", [LOG; 2], RESOLVED, |p| {
            p.numbers.damping.filter(|d| *d > LEAST_DAMPING)
        }),
    ];
    // κ Ω² and σ Ω³
    let expanded: [fn([f64; 2]) -> f64; 2] =
        [|[elongation, _]| elongation.abs(), |[_, damping]| damping];
    for ((graph, slope), expanded) in out[3..].iter_mut().zip([2.0, 3.0]).zip(expanded) {
        graph.slopes = vec![slope];
        for (k, (_, s)) in spectra.iter().enumerate() {
            let lines = broken(&s.points, |p| p.expansion.map(expanded)).into_iter();
            let curves = lines.map(|line| PlotCurve::new(s.scheme.clone(), line).colored(k));
            graph.curves.extend(curves);
        }
    }
    out
}

/// Magnitudes of positions and velocities after the first step.
fn overshoot(spectra: &[(Scheme, Spectrum)]) -> Vec<Graph> {
    let graph = |y, vertical, number| Graph {
        level: Some(1.0),
        ..graph(spectra, y, [LOG, vertical], f64::INFINITY, number)
    };
    vec![
        graph("|q₁/q₀|, first step from rest", LINEAR, |p| {
            stable(p, p.first_step.from_rest[0])
        }),
        graph("|q̇₁/(ω q₀)|, first step from rest", LOG, |p| {
            stable(p, p.first_step.from_rest[1]).filter(above_zero)
        }),
        graph("|ω q₁/q̇₀|, first step from q = 0", LOG, |p| {
            stable(p, p.first_step.from_origin[0]).filter(above_zero)
        }),
        graph("|q̇₁/q̇₀|, first step from q = 0", LINEAR, |p| {
            stable(p, p.first_step.from_origin[1])
        }),
    ]
}

/// Approximate number of marks on a curve.
const MARKS: usize = 10;

/// Points of a curve at equal distances along an axis; a `shift` by a fraction of them separates the marks of
/// several curves.
fn marks(points: &[(f64, f64)], scale: AxisScale, shift: f64) -> Vec<(f64, f64)> {
    let position = |p: &(f64, f64)| match scale {
        AxisScale::Linear => p.0,
        AxisScale::Logarithmic => p.0.ln(),
    };
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return Vec::new();
    };
    let [from, to] = [first, last].map(position);
    let step = (to - from) / MARKS as f64;
    let nearest = |k: usize| {
        let gap = |p: &(f64, f64)| (position(p) - (from + (k as f64 + shift) * step)).abs();
        let nearest = points.iter().min_by(|a, b| gap(a).total_cmp(&gap(b)));
        nearest.copied()
    };
    (0..MARKS).filter_map(nearest).collect()
}

/// Spectral radii above this are beyond the stable step.
const HIGHEST: f64 = 1.1;
/// Damping ratios below this are rounding.
const LEAST_DAMPING: f64 = 1e-12;

/// The magnitude of a result of the first step, if the scheme is stable.
fn stable(p: &integrator::Accuracy, number: f64) -> Option<f64> {
    (p.numbers.radius <= HIGHEST).then_some(number.abs())
}

/// Whether a magnitude can be drawn on a logarithmic axis.
fn above_zero(size: &f64) -> bool {
    *size >= 1e-3
}

/// A broken line: every second part of a curve up to [`RESOLVED`].
fn broken(
    points: &[SpectrumPoint],
    pick: impl Fn(&SpectrumPoint) -> Option<f64>,
) -> Vec<Vec<(f64, f64)>> {
    let inside = points.iter().filter(|p| p.steps.Omega <= RESOLVED);
    let all: Vec<_> = inside
        .filter_map(|p| pick(p).map(|y| (p.steps.Omega, y)))
        .filter(|(_, y)| *y > LEAST_DAMPING)
        .collect();
    let parts = all.chunks(4).step_by(2);
    parts.map(<[_]>::to_vec).collect()
}
