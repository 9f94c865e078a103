//! Errors of schemes that cost the same.

use super::{Quantity, Row, Values};
use serde::Serialize;

/// Errors of all schemes at a cost that lies within the runs of each of them: between neighbouring
/// step sizes log error is interpolated linearly over log cost.
#[derive(Clone, Debug, Serialize)]
pub struct EqualCost {
    /// The cost: seconds of the integration alone where they were taken, or else evaluations.
    pub cost: f64,
    /// Whether it is a time.
    pub seconds: bool,
    /// Schemes and their errors; those that came to no end at two step sizes are missing.
    pub schemes: Vec<(String, Values)>,
}

/// Finds the largest cost that all schemes have in common.
pub(super) fn find(schemes: &[String], rows: &[Row]) -> Option<EqualCost> {
    let seconds = rows.iter().any(|row| row.seconds_alone.is_some());
    let cost = |row: &Row| match seconds {
        true => row.seconds_alone,
        false => Some(row.counts.evaluations as f64),
    };
    let mut curves = Vec::new();
    for scheme in schemes {
        let own = rows
            .iter()
            .filter(|row| row.scheme == *scheme && row.is_regular());
        let mut points: Vec<(f64, Values)> = own
            .filter_map(|row| Some((cost(row)?.ln(), row.error?)))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        if points.len() >= 2 {
            curves.push((scheme, points));
        }
    }
    let end = |points: &[(f64, Values)]| points.last().map_or(f64::NAN, |p| p.0);
    let common = curves.iter().map(|(_, p)| end(p)).reduce(f64::min)?;
    let schemes = curves.iter().map(|(name, points)| {
        let errors = Quantity::ALL.map(|q| at(points, common, q).unwrap_or(f64::NAN));
        ((*name).clone(), Values(errors))
    });
    Some(EqualCost {
        cost: common.exp(),
        seconds,
        schemes: schemes.collect(),
    })
}

/// The error in a quantity at a cost, if it lies within the runs.
fn at(points: &[(f64, Values)], cost: f64, quantity: Quantity) -> Option<f64> {
    let pair = points
        .windows(2)
        .find(|p| p[0].0 <= cost && cost <= p[1].0)?;
    let [(from, a), (to, b)] = [pair[0], pair[1]];
    let [a, b] = [a, b].map(|v| v.of(quantity).ln());
    let part = if to > from {
        (cost - from) / (to - from)
    } else {
        1.0
    };
    // Errors of zero have no logarithm: there is nothing between them.
    Some((a + (b - a) * part).exp()).filter(|e| e.is_finite())
}
