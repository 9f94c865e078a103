//! Errors of schemes at equal cost.

use super::{ComparisonRow, ErrorQuantity, Reference, Values};
use serde::Serialize;

/// Errors of all schemes at one cost: log error is interpolated linearly over log cost between
/// neighbouring step sizes. The cost is the middle (of logarithms) of the common range of all schemes. If
/// there is none it is the middle of the gap, and the nearest two runs are extrapolated, unless their costs are
/// nearly equal, which would make the slope arbitrary.
#[derive(Clone, Debug, Serialize)]
pub struct EqualCost {
    /// The cost: assemblies of the model, or seconds of the integration alone.
    pub cost: f64,
    /// Whether it is a time.
    pub seconds: bool,
    /// Schemes, their errors (NaN next to an error below that of the reference), and whether these are extrapolated; schemes
    /// without two runs in equal steps are missing.
    pub schemes: Vec<(String, Values, bool)>,
}

impl EqualCost {
    /// Finds a common cost, a time or a number of assemblies, and the errors there.
    pub fn find(
        schemes: &[String],
        rows: &[ComparisonRow],
        reference: Option<&Reference>,
        seconds: bool,
    ) -> Option<Self> {
        // An error below that of the reference is unknown.
        let known = |errors: Values| {
            Values(ErrorQuantity::ALL.map(|q| {
                let least = reference.map_or(0.0, |r| r.error.of(q));
                let error = errors.of(q);
                if error < least { f64::NAN } else { error }
            }))
        };
        let cost = |row: &ComparisonRow| match seconds {
            true => row.seconds_alone,
            false => Some(row.assemblies as f64),
        };
        let mut curves = Vec::new();
        for scheme in schemes {
            let own = rows
                .iter()
                .filter(|row| row.scheme == *scheme && row.is_regular());
            let points = own.filter_map(|row| Some((cost(row)?.ln(), known(row.error?))));
            let mut points: Vec<(f64, Values)> = points.collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            if points.len() >= 2 {
                curves.push((scheme, points));
            }
        }
        let ends = (curves.iter()).filter_map(|(_, p)| Some((p.first()?.0, p.last()?.0)));
        let common = ends.reduce(|a, b| (a.0.max(b.0), a.1.min(b.1)))?;
        let cost = 0.5 * (common.0 + common.1);
        let schemes = curves.iter().map(|(name, points)| {
            let errors = ErrorQuantity::ALL.map(|q| at(points, cost, q).unwrap_or(f64::NAN));
            let beyond = points.iter().all(|p| p.0 > cost) || points.iter().all(|p| p.0 < cost);
            ((*name).clone(), Values(errors), beyond)
        });
        Some(Self {
            cost: cost.exp(),
            seconds,
            schemes: schemes.collect(),
        })
    }
}

/// Ratio of costs below which two runs are not extrapolated.
const APART: f64 = 1.4;

/// The error in a quantity at a cost, on the line through the two adjacent or nearest runs.
fn at(points: &[(f64, Values)], cost: f64, quantity: ErrorQuantity) -> Option<f64> {
    let behind = points.iter().position(|p| p.0 >= cost);
    let behind = behind.unwrap_or(points.len()).clamp(1, points.len() - 1);
    let [(from, a), (to, b)] = [points[behind - 1], points[behind]];
    if !(from..=to).contains(&cost) && to - from < APART.ln() {
        return None;
    }
    let [a, b] = [a, b].map(|v| v.of(quantity).ln());
    let part = match to > from {
        true => (cost - from) / (to - from),
        false => 1.0,
    };
    // Errors of zero have no logarithm: no interpolation.
    Some((a + (b - a) * part).exp()).filter(|e| e.is_finite())
}
