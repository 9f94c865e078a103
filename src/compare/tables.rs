//! `compare.csv`, and the tables of the page.

use super::{Comparison, NEAR, Order, Quantity, Row, SchemeOrders};
use std::fmt::Write;

/// Columns of `compare.csv` before and after the errors.
const BEFORE: [&str; 5] = ["run", "scheme", "step_asked", "step", "status"];
const AFTER: [&str; 19] = [
    "energy_drift",
    "momentum_drift",
    "angular_momentum_drift",
    "violation",
    "energy_balance_defect",
    "energy_trend",
    "largest_energy",
    "steps",
    "rejected",
    "iterations",
    "evaluations",
    "assemblies",
    "factorisations",
    "chart_changes",
    "seconds",
    "seconds_alone",
    "threads",
    "regular",
    "failure",
];

/// The whole of `compare.csv`: a row per run, those that are compared, then those with charts that are kept and the long ones; what is
/// not known is empty.
pub(super) fn csv(comparison: &Comparison) -> String {
    let errors = Quantity::ALL.map(|q| format!("error_{}", q.key()));
    let head: Vec<&str> = (BEFORE.into_iter())
        .chain(errors.iter().map(String::as_str))
        .chain(AFTER)
        .collect();
    let mut out = head.join(",") + "\n";
    let compared = comparison.rows.iter().map(|row| ("compared", row));
    let long = comparison.long.iter().map(|row| ("long", row));
    let late = comparison.late.iter().map(|row| ("late", row));
    for (run, row) in compared.chain(late).chain(long) {
        let optional = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x:e}"));
        let c = &row.counts;
        let d = row.drift;
        let mut cells = vec![
            run.to_owned(),
            row.scheme.clone(),
            row.asked.to_string(),
            row.step.to_string(),
            status(row).to_owned(),
        ];
        cells.extend(Quantity::ALL.map(|q| optional(row.error.map(|e| e.of(q)))));
        let drifts = [
            d.energy,
            d.momentum,
            d.angular_momentum,
            d.violation,
            d.balance,
            d.trend,
            d.largest_energy,
        ];
        cells.extend(drifts.map(optional));
        let counts = [
            c.steps,
            c.rejected,
            c.iterations,
            c.evaluations,
            row.assemblies,
            c.factorisations,
            c.chart_changes,
        ];
        cells.extend(counts.map(|n| n.to_string()));
        cells.push(optional(Some(row.seconds)));
        cells.push(optional(row.seconds_alone));
        cells.push(comparison.threads.to_string());
        cells.push(row.is_regular().to_string());
        cells.push(quoted(row.failure.as_deref().unwrap_or_default()));
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{}", cells.join(","));
    }
    out
}

/// A cell of text: one line, in quotation marks.
fn quoted(text: &str) -> String {
    if text.is_empty() {
        return String::new();
    }
    let line = text.lines().map(str::trim).collect::<Vec<_>>().join(" | ");
    format!("\"{}\"", line.replace('"', "\"\""))
}

/// How a run ended, in a word.
pub(super) fn status(row: &Row) -> &'static str {
    match row.failure.as_deref() {
        None => "complete",
        Some("interrupted") => "interrupted",
        Some(_) => "failed",
    }
}

/// The observed orders, for a terminal.
pub fn summary(comparison: &Comparison) -> String {
    let width = comparison.orders.iter().map(|o| o.scheme.chars().count());
    let width = width.max().unwrap_or(0).max("scheme".len());
    let mut out = format!("{:width$}  theory", "scheme");
    for quantity in Quantity::ALL {
        let _ = write!(out, "  {:>18}", quantity.name());
    }
    for scheme in &comparison.orders {
        let _ = write!(
            out,
            "\n{:width$}  {:>6}",
            scheme.scheme,
            theory(scheme.theory)
        );
        for quantity in Quantity::ALL {
            let doubt = if scheme.is_asymptotic(quantity) {
                ""
            } else {
                "?"
            };
            let text = |o: Order| format!("{}{doubt} ({})", order(&o), o.points);
            let text = scheme.of(quantity).map_or("-".to_owned(), text);
            let _ = write!(out, "  {text:>18}");
        }
    }
    let doubtful = |o: &SchemeOrders, q| o.of(q).is_some() && !o.is_asymptotic(q);
    let mut all = comparison.orders.iter();
    if all.any(|o| Quantity::ALL.into_iter().any(|q| doubtful(o, q))) {
        let _ = write!(
            out,
            "\n? no order: fewer than three steps on a line, or its slope more than {NEAR} from theory"
        );
    }
    let failed = comparison.rows.iter().filter(|row| row.failure.is_some());
    for row in failed {
        let reason = row.failure.as_deref().unwrap_or_default();
        let reason = reason.lines().next().unwrap_or_default();
        let _ = write!(out, "\n{} with h = {}: {reason}", row.scheme, row.step);
    }
    out
}

/// A number of three digits, as a page shows it.
pub(super) fn short(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    if !x.is_finite() {
        return "–".to_owned();
    }
    let text = format!("{x:.2e}");
    let (number, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    match exponent.parse::<i32>() {
        Ok(k) if (-3..4).contains(&k) => {
            format!("{x:.*}", (2 - k).max(0) as usize)
        }
        _ => format!("{number}·10<sup>{}</sup>", exponent.replace('-', "−")),
    }
    .replace("-", "−")
}

/// An order in theory, where there is one.
pub(super) fn theory(order: Option<usize>) -> String {
    order.map_or("-".to_owned(), |order| order.to_string())
}

/// An order with its confidence.
pub(super) fn order(order: &Order) -> String {
    let digits = match order.confidence {
        Some(c) if c < 0.005 => 3,
        _ => 2,
    };
    let confidence = match order.confidence {
        None => String::new(),
        Some(c) if c < 5e-4 => " ± <0.001".to_owned(),
        Some(c) => format!(" ± {c:.digits$}"),
    };
    format!("{:.digits$}{confidence}", order.order)
}
