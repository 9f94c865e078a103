//! The helical beam: rotations far beyond π, at most loads with elements whose nodes are in different charts.

#![allow(
    clippy::toplevel_ref_arg,
    reason = "the macro `stack` of nalgebra expands to it"
)]

use super::case::{CaseProblem, CaseReport, StepRecord, order, peak};
use crate::input::Interpolation;
use crate::output::plot::PlotCurve;
use nalgebra::{Matrix3, Matrix3x4, Vector3, stack};
use pullback_integrators::statics::StaticOptions;
use pullback_manifold::so3::skew;

/// The first maximum of the tip's displacement out of the plane: load and value, by the parabola through the largest
/// recorded point and its neighbours.
fn first_maximum(records: &[StepRecord]) -> (f64, f64) {
    let points: Vec<(f64, f64)> = records.iter().map(|r| (r.t, r.state.d.z)).collect();
    let falls = |k: &usize| points[*k].1 >= points[*k + 1].1;
    let first = (1..points.len().saturating_sub(1)).find(falls);
    first.map_or((f64::NAN, f64::NAN), |k| peak(&points, k))
}

/// Length, EA = GA, GJ = EI, and the loads of the model file at load factor 1.
const LENGTH: f64 = 10.0;
const STRETCH: f64 = 1e4;
const BEND: f64 = 1e2;
const FORCE: f64 = 50.0;
const MOMENT: f64 = 200.0 * std::f64::consts::PI;

/// End of the curve whose tip is assumed at `tip`, by Runge and Kutta's method.
///
/// With dead loads at the tip alone, equilibrium gives n = F and m = M + (x_L − x) × F everywhere,
/// and x′ = R (E₁ + C_n⁻¹ Rᵀ n), R′ = R (C_m⁻¹ Rᵀ m)~.
fn shoot(load: f64, tip: &Vector3<f64>) -> Vector3<f64> {
    let n = Vector3::z() * (load * FORCE);
    // Position and directors along the curve.
    let rates = |y: &Matrix3x4<f64>| {
        let (x, R) = (y.fixed_columns::<1>(0), y.fixed_columns::<3>(1));
        let m = Vector3::z() * (load * MOMENT) + (tip - x).cross(&n);
        let (Gamma, K) = (R.tr_mul(&n) / STRETCH, R.tr_mul(&m) / BEND);
        stack![R * (Vector3::x() + Gamma), R * skew(&K)]
    };
    let start = stack![Vector3::zeros(), Matrix3::identity()];
    let h = LENGTH / 600.0;
    let end = (0..600).fold(start, |y, _| {
        let k1 = rates(&y);
        let k2 = rates(&(y + k1 * (0.5 * h)));
        let k3 = rates(&(y + k2 * (0.5 * h)));
        let k4 = rates(&(y + k3 * h));
        y + (k1 + (k2 + k3) * 2.0 + k4) / 6.0 * h
    });
    end.column(0).into_owned()
}

/// Tip of the exact curve at each load, found by Newton's method from the tip at the load before.
fn exact_tips(loads: &[f64]) -> Vec<Vector3<f64>> {
    let mut tip = Vector3::x() * LENGTH;
    let newton = |&load: &f64| {
        for _ in 0..6 {
            let gap = |tip: &Vector3<f64>| shoot(load, tip) - tip;
            let (f, e) = (gap(&tip), 1e-6);
            if f.norm() < 1e-10 {
                break;
            }
            let columns = [0, 1, 2].map(|k| (gap(&(tip + Vector3::ith(k, e))) - f) / e);
            let step = Matrix3::from_columns(&columns).lu().solve(&f);
            tip -= step.unwrap_or(Vector3::repeat(f64::NAN));
        }
        tip
    };
    loads.iter().map(newton).collect()
}

/// Case 2 of [M04]: the helical beam with 100 and 200 elements, and with 100 geodesic ones. Its plot redraws Fig. 31.
pub(super) fn run(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("helix")?;
    let mut heights = Vec::new();
    let mut curves = Vec::new();
    let mut distances = Vec::new();
    for (elements, interpolation, name) in [
        (100, Interpolation::Total, "100 elements"),
        (200, Interpolation::Total, "200 elements"),
        (100, Interpolation::Geodesic, "100 geodesic elements"),
    ] {
        let mut file = file.clone();
        file.lines[0].elements = elements;
        file.lines[0].interpolation = interpolation;
        let records = report.build(&file, "tip")?.solve(&StaticOptions {
            first_step: 0.001,
            max_step: 0.004,
            ..StaticOptions::default()
        })?;
        let (load, value) = first_maximum(&records);
        let source = "published: figure in Mäkinen 2004 4.2, as described";
        report.compare(format!("first maximum, {name}"), value, 3.28, 0.05, source);
        let quantity = format!("load factor of the first maximum, {name}");
        report.compare(quantity, load, 0.036, 0.002, source);
        let last = records.last().map_or(f64::NAN, |r| r.t);
        let quantity = format!("load factor reached, {name}");
        report.compare(quantity, last, 1.0, 0.0, "the whole path");
        heights.push(records.last().map_or(f64::NAN, |r| r.state.d.z));
        let loads: Vec<f64> = records.iter().map(|r| r.t).collect();
        let exact = exact_tips(&loads);
        let squares = records.iter().zip(&exact);
        let squares = squares.map(|(r, tip)| (r.state.d.z - tip.z).powi(2));
        // Root mean square over the steps.
        distances.push((squares.sum::<f64>() / exact.len() as f64).sqrt());
        let points = std::iter::once((0.0, 0.0))
            .chain(records.iter().map(|r| (r.t, r.state.d.z)))
            .collect();
        curves.push(PlotCurve::new(name, points));
    }
    // The mesh error of Ψ's linear interpolation is a drift of the whole curve.
    let what = "height of the tip at full load, 100 over 200 elements";
    let source = "published: about 2.5 (description of the figure)";
    report.compare(what, heights[0] / heights[1], 2.5, 0.5, source);
    const EXACT: &str = "exact curve: shooting from the tip's equilibrium";
    let quantity = "mean distance of the tip along e3 from the exact curve";
    let what = format!("order of the {quantity}, 100 to 200 elements");
    report.compare(what, order(distances[0], distances[1]), 2.0, 0.1, EXACT);
    // Half as many geodesic elements must be closer.
    let what = format!("{quantity}, 100 geodesic over 200 elements");
    report.compare(what, distances[2] / distances[1], 0.0, 0.5, EXACT);
    report.figure(
        "Helical beam",
        ["load factor", "tip displacement along e3"],
        curves,
    )
}
