//! Figures of spectra.

use super::{Point, RESOLVED, Spectrum};
use crate::output::plot::{Curve, Division, Graph, PlotError, graphs};
use pullback_integrators::dynamics::Scheme;

const TITLE: &str = "Lines: closed forms; marks: by the steps that runs make";

/// Figures by their file names: spectra, and the overshoot of the first step.
///
/// # Errors
/// [`PlotError`] of the drawing library.
pub fn figures(spectra: &[(Scheme, Spectrum)]) -> Result<[(&'static str, String); 2], PlotError> {
    type Pick = fn(&Point) -> Option<f64>;
    let graph = |y: &str, division: [Division; 2], from: f64, to: f64, by: [Pick; 2]| {
        let [steps, closed] = by;
        let mut curves = Vec::new();
        for (k, (_, s)) in spectra.iter().enumerate() {
            let inside = || s.points.iter().filter(|p| (from..=to).contains(&p.Omega));
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
        Graph {
            description: ["Ω = ω h".to_owned(), y.to_owned()],
            division,
            curves,
            marked: false,
            slopes: Vec::new(),
            level: None,
        }
    };
    let (linear, log) = (Division::Linear, Division::Logarithmic);
    // What grows is shown up to where it is seen to.
    let radius: Pick = |p| (p.radius <= HIGHEST).then_some(p.radius);
    let closed_radius: Pick = |p| p.closed_radius.filter(|r| *r <= HIGHEST);
    let mut spectra_graphs = [
        graph(
            "spectral radius",
            [log, linear],
            0.0,
            f64::INFINITY,
            [radius, closed_radius],
        ),
        graph(
            "damping ratio",
            [linear, linear],
            0.0,
            RESOLVED,
            [|p| p.damping, |p| p.closed_damping],
        ),
        graph(
            "period elongation",
            [linear, linear],
            0.0,
            RESOLVED,
            [|p| p.elongation, |p| p.closed_elongation],
        ),
        graph(
            "|period elongation|",
            [log, log],
            0.0,
            RESOLVED,
            [
                |p| p.elongation.map(f64::abs),
                |p| p.closed_elongation.map(f64::abs),
            ],
        ),
    ];
    // κ Ω²
    spectra_graphs[3].slopes = vec![2.0];
    let place: Pick = |p| (p.radius <= HIGHEST).then_some(p.rest_place.abs());
    // Where it passes zero, a logarithm falls without end.
    let velocity: Pick = |p| {
        let seen = p.radius <= HIGHEST && p.rest_velocity.abs() >= 1e-3;
        seen.then_some(p.rest_velocity.abs())
    };
    let closed_place: Pick = |p| {
        let known = p.closed_rest_place.filter(|_| p.radius <= HIGHEST);
        known.map(f64::abs)
    };
    let closed_velocity: Pick = |p| {
        let known = p.closed_rest_velocity.map(f64::abs);
        known.filter(|v| p.radius <= HIGHEST && *v >= 1e-3)
    };
    let mut overshoot = [
        graph(
            "|q₁/q₀|, first step from rest",
            [log, linear],
            0.0,
            f64::INFINITY,
            [place, closed_place],
        ),
        graph(
            "|q̇₁/(ω q₀)|, first step from rest",
            [log, log],
            0.0,
            f64::INFINITY,
            [velocity, closed_velocity],
        ),
    ];
    overshoot
        .iter_mut()
        .for_each(|graph| graph.level = Some(1.0));
    Ok([
        ("spectrum.svg", graphs(Some(TITLE), "", &spectra_graphs)?),
        (
            "overshoot.svg",
            graphs(Some(TITLE), "largest value of exact motion", &overshoot)?,
        ),
    ])
}

/// Marks on a curve, about.
const MARKS: usize = 10;

/// Points of a curve at equal distances along an axis; a `shift` by a part of them keeps the marks of
/// several curves from lying above each other.
fn marks(points: &[(f64, f64)], division: Division, shift: f64) -> Vec<(f64, f64)> {
    let place = |p: &(f64, f64)| match division {
        Division::Linear => p.0,
        Division::Logarithmic => p.0.ln(),
    };
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return Vec::new();
    };
    let (from, step) = (place(first), (place(last) - place(first)) / MARKS as f64);
    let aims = (0..MARKS).map(|k| from + (k as f64 + shift) * step);
    aims.filter_map(|aim| {
        let gap = |p: &&(f64, f64)| (place(p) - aim).abs();
        points
            .iter()
            .min_by(|a, b| gap(a).total_cmp(&gap(b)))
            .copied()
    })
    .collect()
}

/// Spectral radii above this are beyond the stable step.
const HIGHEST: f64 = 1.1;
