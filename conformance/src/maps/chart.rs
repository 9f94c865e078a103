//! The laws of a chart: coordinates and points determine each other, in every chart there is.

use super::map::{TIME, laws, short_name};
use crate::report::Report;
use crate::sample::{CLEARANCE, Random};
use nalgebra::SVector;
use pullback_manifold::chart::Chart;
use pullback_manifold::map::Map;

/// Coordinates are recovered to this fraction of their size.
///
/// A logarithm loses at most the inverse of the distance 0.3 to the edge of its chart; some ten
/// operations of 1e-16 each remain below 1e-14.
const RECOVERED: f64 = 1e-12;

/// Checks every law of a chart, and of its change of chart as a map, at every position inside it.
pub fn chart<C, const D: usize>(chart: &C) -> Report
where
    C: Chart<D>,
{
    let mut report = Report::new(short_name::<C>());
    let mut random = Random::default();
    let mut evaluated = 0;
    for (at, q) in random.positions(D) {
        let q = SVector::<f64, D>::from_column_slice(&q);
        let margin = chart.margin(&q);
        if margin.is_nan() || margin <= CLEARANCE {
            continue;
        }
        evaluated += 1;
        let allowed = RECOVERED * (1.0 + q.norm());
        let point = chart.point(&q);
        report.defect(
            "coordinates(point(q)) = q",
            at,
            (chart.coordinates(&point, &q) - q).norm(),
            allowed,
        );
        // The hint `near` picks among charts; it is not where the answer comes from.
        let mut aside = SVector::<f64, D>::zeros();
        random.direction(0.01, aside.as_mut_slice());
        report.defect(
            "coordinates do not depend on the neighbour",
            at,
            (chart.coordinates(&point, &(q + aside)) - q).norm(),
            allowed,
        );
        let Some(transition) = chart.transition(&q) else {
            continue;
        };
        let other = transition.phi(0.0, &q);
        report.defect(
            "transition keeps the point",
            at,
            (chart.coordinates(&point, &other) - other).norm(),
            allowed,
        );
        report.defect(
            "transition can be undone",
            at,
            (chart.coordinates(&chart.point(&other), &q) - q).norm(),
            allowed,
        );
        // Never closer to the edge: positive where the margin shrinks.
        let shrinks = (margin - chart.margin(&other)).max(0.0);
        report.defect("transition leads away from the edge", at, shrinks, 0.0);
        report.defect(
            "transition is not due again",
            at,
            f64::from(u8::from(chart.transition(&other).is_some())),
            0.0,
        );
        report.defect(
            "transition is an involution",
            at,
            (transition.phi(0.0, &other) - q).norm(),
            allowed,
        );
        // Velocities, accelerations, forces and their stiffness: the laws of the map itself.
        laws(
            &mut report,
            "transition: ",
            &transition,
            at,
            TIME,
            &q,
            &mut random,
        );
    }
    if evaluated == 0 {
        report.impossible("domain", "everywhere", "no position is inside the chart");
    }
    report
}
