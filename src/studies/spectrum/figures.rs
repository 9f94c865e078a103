//! Figures of spectra.

use super::{Pick, Point, RESOLVED, Spectrum};
use crate::output::plot::{Curve, Division, Graph, PlotError, graphs};
use pullback_integrators::dynamics::Scheme;

const TITLE: &str = "Lines: closed forms; marks: by the steps that runs make";
const EXPANDED: &str = "; broken: κ Ω² and σ Ω³ of theory";

/// Figures by their file names: spectra, and the overshoot of the first step.
///
/// # Errors
/// [`PlotError`] of the drawing library.
pub fn figures(spectra: &[(Scheme, Spectrum)]) -> Result<[(&'static str, String); 2], PlotError> {
    let graph = |y: &str, division: [Division; 2], to: f64, by: [Pick; 2]| {
        let [steps, closed] = by;
        let mut curves = Vec::new();
        for (k, (_, s)) in spectra.iter().enumerate() {
            let inside = || s.points.iter().filter(|p| p.Omega <= to);
            let at = |p: &Point, y: f64| (p.Omega, y);
            let points = |pick: Pick| -> Vec<(f64, f64)> {
                inside().filter_map(|p| pick(p).map(|y| at(p, y))).collect()
            };
            let all = points(steps);
            let marks = marks(&all, division[0], k as f64 / spectra.len() as f64);
            let known = points(closed);
            let line = if known.is_empty() { all } else { known };
            curves.push(Curve::new(s.scheme.clone(), line).colored(k));
            curves.push(Curve::points(s.scheme.clone(), marks).colored(k));
        }
        Graph::new(["Ω = ω h".to_owned(), y.to_owned()], division, curves)
    };
    let all = |y: &str, division, by| graph(y, division, f64::INFINITY, by);
    let resolved = |y: &str, division, by| graph(y, division, RESOLVED, by);
    let (linear, log) = (Division::Linear, Division::Logarithmic);
    // Growth is shown in part only.
    let radius: Pick = |p| (p.radius <= HIGHEST).then_some(p.radius);
    let closed_radius: Pick = |p| p.closed_radius.filter(|r| *r <= HIGHEST);
    // Rounding errors of a scheme without damping have no logarithm.
    let damping: Pick = |p| p.damping.filter(|d| *d > LEAST_DAMPING);
    let closed_damping: Pick = |p| p.closed_damping.filter(|d| *d > LEAST_DAMPING);
    let ratio: [Pick; 2] = [|p| p.damping, |p| p.closed_damping];
    let elongation: [Pick; 2] = [|p| p.elongation, |p| p.closed_elongation];
    let magnitude: [Pick; 2] = [
        |p| p.elongation.map(f64::abs),
        |p| p.closed_elongation.map(f64::abs),
    ];
    let mut spectra_graphs = [
        all("spectral radius", [log, linear], [radius, closed_radius]),
        resolved("damping ratio", [linear, linear], ratio),
        resolved("period elongation", [linear, linear], elongation),
        resolved("|period elongation|", [log, log], magnitude),
        resolved("damping ratio", [log, log], [damping, closed_damping]),
    ];
    // κ Ω² and σ Ω³
    let expanded: [Pick; 2] = [
        |p| p.expanded_elongation.map(f64::abs),
        |p| p.expanded_damping,
    ];
    for ((graph, slope), expanded) in spectra_graphs[3..].iter_mut().zip([2.0, 3.0]).zip(expanded) {
        graph.slopes = vec![slope];
        for (k, (_, s)) in spectra.iter().enumerate() {
            let lines = broken(&s.points, expanded).into_iter();
            let curves = lines.map(|line| Curve::new(s.scheme.clone(), line).colored(k));
            graph.curves.extend(curves);
        }
    }
    let rest: [[Pick; 2]; 2] = [
        [
            |p| seen(p, p.rest_position),
            |p| seen(p, p.closed_rest_position?),
        ],
        [
            |p| above_zero(p, p.rest_velocity),
            |p| above_zero(p, p.closed_rest_velocity?),
        ],
    ];
    let origin: [[Pick; 2]; 2] = [
        [
            |p| above_zero(p, p.origin_position),
            |p| above_zero(p, p.closed_origin_position?),
        ],
        [
            |p| seen(p, p.origin_velocity),
            |p| seen(p, p.closed_origin_velocity?),
        ],
    ];
    let overshoot = [
        all("|q₁/q₀|, first step from rest", [log, linear], rest[0]),
        all("|q̇₁/(ω q₀)|, first step from rest", [log, log], rest[1]),
        all("|ω q₁/q̇₀|, first step from q = 0", [log, log], origin[0]),
        all("|q̇₁/q̇₀|, first step from q = 0", [log, linear], origin[1]),
    ];
    let overshoot = overshoot.map(|graph| Graph {
        level: Some(1.0),
        ..graph
    });
    Ok([
        (
            "spectrum.svg",
            graphs(Some(&format!("{TITLE}{EXPANDED}")), "", &spectra_graphs)?,
        ),
        (
            "overshoot.svg",
            graphs(Some(TITLE), "largest value of exact motion", &overshoot)?,
        ),
    ])
}

/// Approximate number of marks on a curve.
const MARKS: usize = 10;

/// Points of a curve at equal distances along an axis; a `shift` by a fraction of them separates the marks of
/// several curves.
fn marks(points: &[(f64, f64)], division: Division, shift: f64) -> Vec<(f64, f64)> {
    let position = |p: &(f64, f64)| match division {
        Division::Linear => p.0,
        Division::Logarithmic => p.0.ln(),
    };
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return Vec::new();
    };
    let (from, step) = (
        position(first),
        (position(last) - position(first)) / MARKS as f64,
    );
    let aims = (0..MARKS).map(|k| from + (k as f64 + shift) * step);
    aims.filter_map(|aim| {
        let gap = |p: &&(f64, f64)| (position(p) - aim).abs();
        points
            .iter()
            .min_by(|a, b| gap(a).total_cmp(&gap(b)))
            .copied()
    })
    .collect()
}

/// Spectral radii above this are beyond the stable step.
const HIGHEST: f64 = 1.1;
/// Damping ratios below this are rounding.
const LEAST_DAMPING: f64 = 1e-12;

/// The magnitude of a result of the first step, if the scheme is stable.
fn seen(p: &Point, number: f64) -> Option<f64> {
    (p.radius <= HIGHEST).then_some(number.abs())
}

/// The same without values whose logarithm tends to −∞.
fn above_zero(p: &Point, number: f64) -> Option<f64> {
    seen(p, number).filter(|size| *size >= 1e-3)
}

/// A broken line: every second part of a curve, within its resolution.
fn broken(points: &[Point], pick: impl Fn(&Point) -> Option<f64>) -> Vec<Vec<(f64, f64)>> {
    let inside = points.iter().filter(|p| p.Omega <= RESOLVED);
    let all: Vec<_> = inside
        .filter_map(|p| pick(p).map(|y| (p.Omega, y)))
        .filter(|(_, y)| *y > LEAST_DAMPING)
        .collect();
    let parts = all.chunks(4).step_by(2);
    parts.map(<[_]>::to_vec).collect()
}
