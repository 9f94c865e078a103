//! Comparison of two implementations of an element.

use super::element::{Request, evaluate, motion};
use super::in_charts::InCharts;
use crate::{Report, states};
use pullback_elements::element::Element;

/// Compares an element derived by hand with another implementation, for instance by its
/// [`energy`](pullback_elements::energy): residual, tangents, rate, stored energy and dissipation to 1e-12.
///
/// It finds errors of a force with consistent tangents, which [`element`](super::element()) cannot find.
pub fn same(found: &dyn Element, expected: &dyn Element) -> Report {
    let both = [InCharts(found), InCharts(expected)];
    let [found, expected] = both.each_ref().map(InCharts::element);
    let n = expected.dim();
    let mut report = Report::new(format!("two elements of {n} coordinates"));
    if found.dim() != n {
        let why = format!("{} coordinates and {n}", found.dim());
        report.impossible("dimensions", "everywhere", why);
        return report;
    }
    for (at, s) in &states(n) {
        let pair = [found, expected].map(|e| (e, evaluate(e, s, Request::All)));
        let [(_, Some(f)), (_, Some(e))] = &pair else {
            if pair[0].1.is_some() != pair[1].1.is_some() {
                let why = "inside that of one, outside that of the other";
                report.impossible("domain", at, why);
            }
            continue;
        };
        let mut near = |law: &str, gap: f64, size: f64, cancelled: f64| {
            report.defect(law, at, gap, 1e-12 * size + 1e-14 * cancelled);
        };
        // Values near zero are differences of larger terms: stiffness times coordinates, force times coordinates.
        let (r, K, x) = (e.r.norm(), e.K.norm(), 1.0 + s.x.norm());
        near("r", (&f.r - &e.r).norm(), r, K * x);
        near("K", (&f.K - &e.K).norm(), K, 0.0);
        for (law, found, expected) in [("C", &f.C, &e.C), ("M", &f.M, &e.M)] {
            near(law, (found - expected).norm(), expected.norm(), 0.0);
        }
        if let (Some(found), Some(expected)) = (&f.r_t, &e.r_t) {
            near("r_t", (found - expected).norm(), expected.norm(), 0.0);
        }
        let [a, b] = [found, expected].map(|e| e.abilities().energy(&motion(s)));
        near("energy", (a - b).abs(), b.abs(), r * x);
        let [a, b] = [found, expected].map(|e| e.abilities().dissipation(&motion(s)));
        near("dissipation", (a - b).abs(), b.abs(), 0.0);
    }
    report
}
