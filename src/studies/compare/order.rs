//! Observed orders of convergence and their confidence.

use super::Candidate;
use super::sample::QUANTITIES;
use super::{ComparisonRow, ErrorQuantity, Reference, SchemeOrders, Values};
use serde::Serialize;

/// An observed order: the slope of log error over log step by least squares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Order {
    /// The slope.
    pub order: f64,
    /// Half of the 95 % confidence interval of the slope, with Student's distribution for the
    /// scatter about the line; `None` for two points.
    pub confidence: Option<f64>,
    /// Number of step sizes on the line.
    pub points: usize,
    /// Largest and smallest of them.
    pub steps: [f64; 2],
}

/// Errors below this multiple of the error of the reference are not used.
pub const ABOVE_REFERENCE: f64 = 10.0;
/// Tolerance of slopes between neighbours, against the one between the two finest.
pub const STRAIGHT: f64 = 0.2;
/// Tolerance of slopes against the order in theory, also for the extrapolation of the three runs of a reference.
pub const NEAR: f64 = 0.3;

/// Fits an order to errors at step sizes (from large to small), `None` for an unusable error. Only errors
/// far above the `error` of the reference are used.
///
/// The line begins with the two finest of these and goes on to larger steps as long as
/// the slope between neighbours stays within [`STRAIGHT`] of that between the two finest.
pub fn fit(errors: &[(f64, Option<f64>)], error: f64) -> Option<Order> {
    let usable = errors.iter().rev().filter_map(|&(h, e)| Some((h.ln(), e?)));
    let above = |&(_, e): &(f64, f64)| e.is_finite() && e > 0.0 && e > ABOVE_REFERENCE * error;
    let points: Vec<(f64, f64)> = usable.filter(above).map(|(h, e)| (h, e.ln())).collect();
    let slope = |p: &[(f64, f64)]| (p[1].1 - p[0].1) / (p[1].0 - p[0].0);
    let slopes: Vec<f64> = points.windows(2).map(slope).collect();
    let first = *slopes.first()?;
    let straight = slopes.iter().take_while(|s| (*s - first).abs() <= STRAIGHT);
    let points = &points[..=straight.count()];
    let n = points.len() as f64;
    let mean = |part: fn(&(f64, f64)) -> f64| points.iter().map(part).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let (mut xx, mut xy) = (0.0, 0.0);
    for p in points {
        xx += (p.0 - x).powi(2);
        xy += (p.0 - x) * (p.1 - y);
    }
    let order = xy / xx;
    let residuals = points.iter().map(|p| p.1 - y - order * (p.0 - x));
    let scatter: f64 = residuals.map(|r| r.powi(2)).sum();
    let confidence = student(points.len() - 2).map(|t| t * (scatter / (n - 2.0) / xx).sqrt());
    Some(Order {
        order,
        confidence,
        points: points.len(),
        steps: [points[points.len() - 1].0.exp(), points[0].0.exp()],
    })
}

/// Student's t for a two-sided interval of 95 % with this number of degrees of freedom (tables; beyond ten
/// the expansion about the normal distribution, good to three digits).
fn student(freedom: usize) -> Option<f64> {
    const T: [f64; 10] = [
        12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
    ];
    match freedom {
        0 => None,
        n @ 1..=10 => Some(T[n - 1]),
        n => {
            let (z, n) = (1.959_964_f64, n as f64);
            let first = (z.powi(3) + z) / 4.0;
            let second = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
            let third = (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0;
            Some(z + first / n + second / (n * n) + third / (n * n * n))
        }
    }
}

/// The observed orders of all schemes.
pub(super) fn orders(
    schemes: &[Candidate],
    multipliers: bool,
    rows: &[ComparisonRow],
    reference: Option<&Reference>,
) -> Vec<SchemeOrders> {
    let observed = |name: &str, quantity: ErrorQuantity| {
        let own = rows.iter().filter(|row| row.scheme == name);
        let errors: Vec<_> = own
            .map(|row| (row.step, row.regular_error(quantity)))
            .collect();
        fit(&errors, reference?.error.of(quantity))
    };
    let of = |method: &Candidate| {
        let name = method.to_string();
        SchemeOrders {
            formulation: method.about(),
            theory: method.orders(multipliers),
            // A slope over a tolerance is no order.
            observed: match method.order() {
                Some(_) => Values(ErrorQuantity::ALL.map(|quantity| observed(&name, quantity))),
                None => Values([None; QUANTITIES]),
            },
            scheme: name,
        }
    };
    schemes.iter().map(of).collect()
}
