//! What changes of chart cost, as a comparison tells it, after theory.

use crate::support::comparisons;
use crate::support::dynamics::{assert_order, slopes};
use crate::support::laboratory::options;
use crate::support::program::changed;
use pullback::studies::compare::{Comparison, ComparisonOptions, ComparisonRow, ErrorQuantity};

fn compared(text: &str, methods: &[&str], steps: &[f64]) -> Comparison {
    let options = ComparisonOptions {
        charts: true,
        residual: Some(1e-12),
        ..options(methods, steps)
    };
    let comparison = comparisons::compared(text, &options).unwrap();
    assert_eq!(comparison.charts.len(), comparison.rows.len());
    for (row, late) in comparison.rows.iter().zip(&comparison.charts) {
        assert!(row.is_regular() && late.is_regular(), "{late:?}");
        assert_eq!((&row.scheme, row.step), (&late.scheme, late.step));
    }
    comparison
}

fn rod(spin: &str, interpolation: &str) -> String {
    let analysis = "[analysis.dynamic]\nto = 0.6\nstep = 0.01\n";
    let more = format!("interpolation = {interpolation:?}\n{analysis}");
    comparisons::rod(spin, &more)
}

/// Errors of rotations of a scheme, from large to small steps.
fn errors(rows: &[ComparisonRow], scheme: &str) -> Vec<f64> {
    let own = rows.iter().filter(|row| row.scheme == scheme);
    own.map(|row| row.error.unwrap().of(ErrorQuantity::Rotation))
        .collect()
}

/// About a fixed axis the other chart has the same coordinate less 2π, which no scheme sees.
#[test]
fn in_a_plane_a_change_of_chart_costs_nothing() {
    let text = rod("[0, 0, 8]", "total");
    let comparison = compared(&text, &["newmark", "radau"], &[0.02, 0.01]);
    for (row, late) in comparison.rows.iter().zip(&comparison.charts) {
        // Past half a turn, and past three quarters or nearly.
        assert!(row.counts.chart_changes > late.counts.chart_changes);
        for (a, b) in row.samples.iter().zip(&late.samples) {
            for (a, b) in a.nodes.iter().zip(&b.nodes) {
                assert!((a.R - b.R).norm() < 1e-8 && (a.omega - b.omega).norm() < 1e-7);
            }
        }
    }
}

/// In space the scheme adds in other coordinates: its error is another one, of the same order.
#[test]
fn a_body_keeps_its_order_whenever_charts_change() {
    let steps = [0.01, 0.005, 0.0025];
    // A free body with three different moments of inertia.
    let changes = "[2, 2, 1] => [1, 2, 3]\n[3, 0, 4] => [3, 1, 8]\nto = 2 => to = 0.55";
    let body = changed(comparisons::BODY, changes);
    let comparison = compared(&body, &["newmark", "ul-newmark"], &steps);
    for rows in [&comparison.rows, &comparison.charts] {
        for scheme in ["newmark", "ul-newmark"] {
            assert_order(scheme, &errors(rows, scheme), 2.0, 0.1);
        }
    }
    let total = |rows: &[ComparisonRow]| errors(rows, "newmark")[2];
    let [early, late] = [total(&comparison.rows), total(&comparison.charts)];
    assert!((early - late).abs() > 1e-2 * late, "{early:e} {late:e}");
    // Increments are in no such chart.
    let updated = |rows: &[ComparisonRow]| errors(rows, "ul-newmark");
    let [early, late] = [updated(&comparison.rows), updated(&comparison.charts)];
    for (a, b) in early.iter().zip(&late) {
        assert!((a - b).abs() < 1e-9, "{a:e} {b:e}");
    }
}

/// Elements that interpolate total rotation vectors are other ones in the other chart, by the error of
/// their mesh: what a change does to the motion no step makes smaller. Geodesic ones are the same.
#[test]
fn total_rotation_vectors_lose_the_error_of_the_mesh_and_geodesic_elements_nothing() {
    let steps = [0.004, 0.002, 0.001];
    let [total, geodesic] = ["total", "geodesic"]
        .map(|interpolation| compared(&rod("[2, 1, 8]", interpolation), &["newmark"], &steps));
    for comparison in [&total, &geodesic] {
        for (row, late) in comparison.rows.iter().zip(&comparison.charts) {
            assert!(row.counts.chart_changes > late.counts.chart_changes);
        }
    }
    // How far the two motions are apart, rotation by rotation.
    let apart = |comparison: &Comparison| -> Vec<f64> {
        let pairs = comparison.rows.iter().zip(&comparison.charts);
        let pair = |(row, late): (&ComparisonRow, &ComparisonRow)| {
            let samples = row.samples.iter().zip(&late.samples);
            let nodes = samples.flat_map(|(a, b)| a.nodes.iter().zip(&b.nodes));
            let squares = nodes.map(|(a, b)| (a.R - b.R).norm_squared());
            squares.sum::<f64>().sqrt()
        };
        pairs.map(pair).collect()
    };
    let [total, geodesic] = [apart(&total), apart(&geodesic)];
    assert_order("geodesic", &geodesic, 2.0, 0.1);
    let last = slopes(&total)[1];
    let lost = last.abs() < 0.1 && total[2] > 3.0 * geodesic[2];
    assert!(lost, "{total:?} {geodesic:?}");
}
