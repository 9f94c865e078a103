//! `compare.csv`, and the tables of the page.

use super::ABOVE_REFERENCE;
use super::run::INTERRUPTED;
use super::{Comparison, ComparisonRow, ErrorQuantity, NEAR, Order, SchemeOrders, Slope, Values};
use crate::terminal::longest;

/// The text of a cell of `compare.csv`.
type Cell = fn(&Comparison, &ComparisonRow) -> String;

/// Columns of `compare.csv` between the kind of the run and the errors.
const BEFORE: [(&str, Cell); 4] = [
    ("scheme", |_, row| row.scheme.clone()),
    ("requested_step", |_, row| row.requested_step.to_string()),
    ("step", |_, row| row.step.to_string()),
    ("status", |_, row| status(row).to_owned()),
];

/// Columns after the errors.
const AFTER: [(&str, Cell); 20] = [
    ("energy_drift", |_, row| number(row.drift.energy)),
    ("momentum_drift", |_, row| number(row.drift.momentum)),
    ("angular_momentum_drift", |_, row| {
        number(row.drift.angular_momentum)
    }),
    ("violation", |_, row| number(row.drift.violation)),
    ("energy_balance_defect", |_, row| number(row.drift.balance)),
    ("energy_trend", |_, row| number(row.drift.trend)),
    ("largest_energy", |_, row| number(row.drift.largest_energy)),
    ("steps", |_, row| row.counts.steps.to_string()),
    ("rejected", |_, row| row.counts.rejected.to_string()),
    ("iterations", |_, row| row.counts.iterations.to_string()),
    ("evaluations", |_, row| row.counts.evaluations.to_string()),
    ("assemblies", |_, row| row.assemblies.to_string()),
    ("assemblies_before", |_, row| row.searching.to_string()),
    ("factorisations", |_, row| {
        row.counts.factorisations.to_string()
    }),
    ("chart_changes", |_, row| {
        row.counts.chart_changes.to_string()
    }),
    ("seconds", |_, row| number(Some(row.seconds))),
    ("seconds_alone", |_, row| number(row.seconds_alone)),
    ("threads", |comparison, _| comparison.threads.to_string()),
    ("regular", |_, row| row.is_regular().to_string()),
    ("failure", |_, row| {
        quoted(row.failure.as_deref().unwrap_or_default())
    }),
];

/// A number, empty if it is unknown.
pub(super) fn number(x: Option<f64>) -> String {
    let known = x.filter(|x| !x.is_nan());
    known.map_or_else(String::new, |x| format!("{x:e}"))
}

/// The content of `compare.csv`: a row per run, first those compared, then those with late changes of chart
/// and the long ones; unknown values are empty.
pub(super) fn csv(comparison: &Comparison) -> String {
    let line = |run: &str, cell: &dyn Fn(&(&str, Cell)) -> String, errors: [String; 7]| {
        let (before, after) = (BEFORE.iter().map(cell), AFTER.iter().map(cell));
        let cells: Vec<String> = before.chain(errors).chain(after).collect();
        format!("{run},{}\n", cells.join(","))
    };
    let errors = ErrorQuantity::ALL.map(|q| format!("error_{}", q.key()));
    let mut out = line("run", &|column| column.0.to_owned(), errors);
    let runs = [
        ("compared", &comparison.rows),
        ("charts", &comparison.charts),
        ("long", &comparison.long),
    ];
    for (run, rows) in runs {
        for row in rows {
            let errors = ErrorQuantity::ALL.map(|q| number(row.error.map(|e| e.of(q))));
            out += &line(run, &|column| column.1(comparison, row), errors);
        }
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

/// Failed runs, grouped by scheme and reason.
pub(super) fn failures<'c>(comparison: &'c Comparison) -> Vec<(Vec<&'c ComparisonRow>, &'c str)> {
    let failed = |row: &'c ComparisonRow| Some((row, row.failure.as_deref()?));
    let failed: Vec<_> = comparison.rows.iter().filter_map(failed).collect();
    let alike = failed.chunk_by(|a, b| a.0.scheme == b.0.scheme && a.1 == b.1);
    let group = |group: &[(&'c ComparisonRow, &'c str)]| {
        (group.iter().map(|(row, _)| *row).collect(), group[0].1)
    };
    alike.map(group).collect()
}

/// Status of a run, in a word.
pub(super) fn status(row: &ComparisonRow) -> &'static str {
    match row.failure.as_deref() {
        None => "complete",
        Some(INTERRUPTED) => INTERRUPTED,
        Some(_) => "failed",
    }
}

/// The observed orders, for a terminal.
pub fn summary(comparison: &Comparison) -> String {
    let width = longest(comparison.orders.iter().map(|o| &*o.scheme)).max("scheme".len());
    let mut out = format!("{:width$}  theory", "scheme");
    for quantity in ErrorQuantity::ALL {
        out += &format!("  {:>18}", quantity.name());
    }
    for scheme in &comparison.orders {
        out += &format!("\n{:width$}  {:>6}", scheme.scheme, theory(scheme.theory));
        for quantity in ErrorQuantity::ALL {
            let mark = match scheme.slope(quantity) {
                Some(Slope::Doubtful) => "?",
                Some(Slope::Above) => "+",
                _ => "",
            };
            let text = |o: Order| format!("{}{mark} ({})", order(&o), o.points);
            let text = scheme.of(quantity).map_or("-".to_owned(), text);
            out += &format!("  {text:>18}");
        }
    }
    notes(&mut out, comparison);
    for (failed, reason) in failures(comparison) {
        let scheme = &failed[0].scheme;
        let reason = reason.lines().next().unwrap_or_default();
        out += &match failed.len() > 1 && failed.len() == comparison.of(scheme).count() {
            true => format!("\n{scheme}: {reason}"),
            false => {
                let steps: Vec<String> = failed.iter().map(|row| row.step.to_string()).collect();
                format!("\n{scheme} with h = {}: {reason}", steps.join(", "))
            }
        };
    }
    out
}

/// Explains the marks in the table of orders.
fn notes(out: &mut String, comparison: &Comparison) {
    let any = |found: &dyn Fn(&SchemeOrders, ErrorQuantity) -> bool| {
        let mut all = comparison.orders.iter();
        all.any(|o| ErrorQuantity::ALL.into_iter().any(|q| found(o, q)))
    };
    if any(&|o, q| o.slope(q) == Some(Slope::Doubtful)) {
        *out += &format!(
            "\n? no order: fewer than three steps on a line, or its slope more than {NEAR} below theory"
        );
    }
    if any(&|o, q| o.slope(q) == Some(Slope::Above)) {
        *out += &format!(
            "\n+ above theory by more than {NEAR}: at these steps the leading term of the error is \
             smaller than the next one"
        );
    }
    let measured = |row: &ComparisonRow, q| row.error.is_some_and(|e| e.of(q).is_finite());
    let known = |q| {
        let knows = comparison.reference.as_ref().is_some_and(|r| r.knows(q));
        knows && comparison.rows.iter().any(|row| measured(row, q))
    };
    if let Some(why) = unknown(comparison) {
        *out += &format!("\n- {why}");
    }
    if any(&|o, q| o.theory.is_some() && o.of(q).is_none() && known(q)) {
        *out += &format!(
            "\n- no slope: fewer than two runs without rejected steps have errors of more than \
             {ABOVE_REFERENCE} times that of the reference"
        );
    }
}

/// Quantities without a reference and the reason, in a line, if there are any.
pub fn unknown(comparison: &Comparison) -> Option<String> {
    let reference = comparison.reference.as_ref()?;
    let all = ErrorQuantity::ALL.into_iter();
    let missing: Vec<ErrorQuantity> = all.filter(|q| !reference.knows(*q)).collect();
    if missing.is_empty() {
        return None;
    }
    let names: Vec<&str> = missing.iter().map(|q| q.name()).collect();
    let of = match missing.len() {
        n if n == ErrorQuantity::ALL.len() => "any quantity".to_owned(),
        _ => names.join(", "),
    };
    let order = |q: &ErrorQuantity| format!("{:.2}", reference.order.of(*q));
    let orders: Vec<String> = missing.iter().map(order).collect();
    let other = match reference.scheme.as_str() {
        "radau" => "bathe",
        _ => "radau",
    };
    Some(format!(
        "no reference for {of}: with smaller steps the three runs of {} do not come closer to each \
         other (observed orders {}); take smaller steps, or --reference {other}",
        reference.scheme,
        orders.join(", ").replace('-', "−")
    ))
}

/// A number for a page, if it is known.
pub(super) fn known(x: Option<f64>) -> String {
    x.map_or_else(|| "–".to_owned(), short)
}

/// A sentence that ends with the different ones of some names, if there are any.
pub(super) fn listed(before: &str, names: impl Iterator<Item = String>) -> String {
    let mut different: Vec<String> = Vec::new();
    for name in names {
        if !different.contains(&name) {
            different.push(name);
        }
    }
    match different.is_empty() {
        true => String::new(),
        false => format!("{before}{}.", different.join(", ")),
    }
}

/// A number of three digits, for a page.
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

/// An order in theory, if there is one: 3/2/1 if those of velocities and accelerations differ.
pub(super) fn theory(orders: Option<Values<usize>>) -> String {
    use ErrorQuantity::{Acceleration, Position, Velocity};
    let Some(orders) = orders else {
        return "-".to_owned();
    };
    let mut parts = [Position, Velocity, Acceleration]
        .map(|q| orders.of(q).to_string())
        .to_vec();
    if parts.iter().all(|p| *p == parts[0]) {
        parts.truncate(1);
    }
    parts.join("/")
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
    format!("{:.digits$}{confidence}", order.order).replace('-', "−")
}
