//! Drift of conserved quantities over time.

use super::{ends, lasting, near, rounded};
use crate::output::plot::{AxisScale, Graph, PlotCurve};
use crate::studies::compare::{Comparison, ComparisonRow};

/// The value drawn of a run at a common time.
type Drawn = dyn Fn(&ComparisonRow, usize) -> f64;

/// Most points of a curve: each is the largest value in its part of the run. Oscillations through zero would cover the
/// other curves on a logarithmic axis.
pub(super) const PARTS: usize = 32;

pub(super) fn drift(comparison: &Comparison) -> Vec<Graph> {
    let mut out = Vec::new();
    for (name, value) in &drawn(comparison) {
        for finest in [false, true] {
            let step = ends(comparison)[usize::from(finest)];
            // A long run is preferred to a short one with the same step.
            let rows = match finest || comparison.long.is_empty() {
                true => &comparison.rows,
                false => &comparison.long,
            };
            let schemes = comparison.orders.iter().enumerate();
            let curves = schemes.flat_map(|(k, scheme)| {
                let own = move |r: &&ComparisonRow| r.scheme == scheme.scheme && near(r.step, step);
                let drawn = rows.iter().filter(own).filter(|row| row.samples.len() > 1);
                drawn.map(move |row| {
                    let label = lasting(comparison, &scheme.scheme);
                    PlotCurve::new(label, envelope(row, value)).colored(k)
                })
            });
            let description = [format!("time t,  h = {}", rounded(step)), name.clone()];
            let scale = [AxisScale::Linear, AxisScale::Logarithmic];
            out.push(Graph::new(description, scale, curves.collect()));
        }
    }
    out
}

/// The largest value in each part of a run, at its time; unknown values have no point.
fn envelope(row: &ComparisonRow, value: &Drawn) -> Vec<(f64, f64)> {
    let points = (1..row.samples.len()).map(|j| (row.samples[j].t, value(row, j)));
    let points: Vec<(f64, f64)> = points.collect();
    // Equal numbers of points in all parts: the maximum of a short last part would be too small.
    let parts = PARTS.min(points.len());
    let end = |k: usize| k * points.len() / parts;
    let largest = (0..parts).filter_map(|k| {
        let known = points[end(k)..end(k + 1)].iter().filter(|p| !p.1.is_nan());
        known.max_by(|a, b| a.1.total_cmp(&b.1)).copied()
    });
    largest.collect()
}

/// The change of a quantity since the start of a run.
fn change(of: impl Fn(&ComparisonRow, usize) -> f64 + 'static) -> Box<Drawn> {
    Box::new(move |row, j| (of(row, j) - of(row, 0)).abs())
}

/// The quantities to draw, with the descriptions of their axes.
fn drawn(comparison: &Comparison) -> Vec<(String, Box<Drawn>)> {
    let conserved = comparison.conserved();
    let (name, energy) = match conserved.energy {
        true => ("|change of energy|", change(|row, j| row.samples[j].energy)),
        false => {
            let defect = |row: &ComparisonRow, j: usize| row.samples[j].defect.unwrap_or(f64::NAN);
            ("|defect of the balance of energy|", change(defect))
        }
    };
    let mut out = vec![(name.to_owned(), energy)];
    let vectors = [
        (0, "momentum", conserved.momentum),
        (1, "angular momentum", conserved.angular_momentum),
    ];
    for (k, name, conserved) in vectors {
        let of = |i: usize| change(move |row, j| row.samples[j].momenta[k][i]);
        // The worst of the components.
        let largest = |i: &usize| {
            let value = of(*i);
            let all = comparison.rows.iter();
            let changes = all.flat_map(|row| (0..row.samples.len()).map(move |j| (row, j)));
            changes.fold(0.0, |m: f64, (row, j)| m.max(value(row, j)))
        };
        let worst = (0..3).filter(|&i| conserved[i]);
        let worst = worst.max_by(|a, b| largest(a).total_cmp(&largest(b)));
        if let Some(i) = worst.filter(|i| largest(i) > 0.0) {
            out.push((format!("|change of {name}|, component {}", i + 1), of(i)));
        }
    }
    // The residual itself is drawn, not its change since the start.
    let mut samples = comparison.rows.iter().flat_map(|row| &row.samples);
    if samples.any(|sample| sample.violation.is_some()) {
        let residual: Box<Drawn> =
            Box::new(|row, j| row.samples[j].violation.map_or(f64::NAN, f64::abs));
        out.push(("residual of the loops' equations".to_owned(), residual));
    }
    out
}
