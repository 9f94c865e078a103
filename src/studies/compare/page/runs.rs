//! Tables of the runs: errors, cost, reasons of failures.

use super::{Page, escaped, exact, run_table, with_errors};
use crate::studies::compare::tables::{failures as failures_of, known, listed, short, status};
use crate::studies::compare::{Comparison, ComparisonRow, EqualCost, ErrorQuantity};

pub(super) fn errors(out: &mut Page, c: &Comparison) {
    let caption = format!(
        "Root mean square errors over {} equally spaced times, the start included, and all frame nodes; of rotations the \
         angle of the relative rotation in radians. Where the error is below that of the reference \
         itself, that stands instead, and – where the reference is not known at all.{}",
        c.times + 1,
        changed_steps(c)
    );
    run_table(out, &caption, &with_errors(&[""]), &c.rows, |row| {
        // An error below that of the reference has that one as a bound.
        let least = |q| c.reference_error(q);
        let error = |q| match row.error.map(|e| e.of(q)) {
            None => "–".to_owned(),
            Some(_) if least(q).is_infinite() => "–".to_owned(),
            Some(error) if error < least(q) => format!("&lt; {}", short(least(q))),
            Some(error) => short(error),
        };
        let errors = ErrorQuantity::ALL.map(error).to_vec();
        Some([vec![note(row).to_owned()], errors].concat())
    });
}

/// Step sizes that differ from those requested.
fn changed_steps(c: &Comparison) -> String {
    let changed =
        |row: &&ComparisonRow| (row.step - row.requested_step).abs() > 1e-9 * row.requested_step;
    let pair =
        |row: &ComparisonRow| format!("{} for {}", exact(row.step), exact(row.requested_step));
    let before = " Steps end at kinks of the functions of time and at common times: h is ";
    listed(before, c.rows.iter().filter(changed).map(pair))
}

/// Status of a run, in a word.
fn note(row: &ComparisonRow) -> &'static str {
    match status(row) {
        "complete" if row.counts.rejected > 0 => "steps halved",
        "complete" => "",
        other => other,
    }
}

/// Errors of all schemes at a common cost.
pub(super) fn equal_cost(out: &mut Page, equal: &EqualCost) {
    let (of, what) = match equal.seconds {
        true => (
            "time",
            format!("{} s of integration alone", short(equal.cost)),
        ),
        false => (
            "work",
            format!("{} assemblies of the model", equal.cost.round()),
        ),
    };
    out.heading(2, "", &format!("Errors at equal {of}"));
    let caption = format!(
        "At {what}: log error interpolated over log cost between neighbouring step sizes, or \
         extrapolated from the nearest two (≈); in brackets, over that of the first scheme.",
    );
    out.table(&caption, &with_errors(&["scheme"]), 1);
    for (name, errors, beyond) in &equal.schemes {
        let about = if *beyond { "≈ " } else { "" };
        let mut line = vec![escaped(name)];
        line.extend(ErrorQuantity::ALL.map(|q| {
            let over = errors.of(q) / equal.schemes[0].1.of(q);
            match (errors.of(q), over) {
                (e, _) if !e.is_finite() => "–".to_owned(),
                (e, over) if over.is_finite() => format!("{about}{} ({})", short(e), short(over)),
                (e, _) => format!("{about}{}", short(e)),
            }
        }));
        out.row(false, 1, &line);
    }
    out.end_table();
}

pub(super) fn cost(out: &mut Page, c: &Comparison) {
    let alone = match c.rows.iter().any(|row| row.seconds_alone.is_some()) {
        false => "",
        true => {
            "; alone is that of the integration only, with the search before its first step, the \
             least of some repetitions"
        }
    };
    let beside = match c.threads {
        1 => "one run at a time".to_owned(),
        n => format!("{n} runs in parallel on one machine, which slows each of them down"),
    };
    let caption = format!(
        "Time is wall time with the evaluation of energies and momenta, {beside}{alone}. An evaluation \
         assembles the model once, with a tangent three times where rates are spins. Increments are \
         centred anew in every step, and each time counts as a change of chart.{}",
        searching(c)
    );
    type Cell = fn(&ComparisonRow) -> String;
    let mut columns: Vec<(&str, Cell)> = vec![
        ("steps", |row| row.counts.steps.to_string()),
        ("rejected", |row| row.counts.rejected.to_string()),
        ("solutions per step", |row| match row.counts.steps {
            0 => "–".to_owned(),
            _ => format!("{:.2}", row.iterations_per_step()),
        }),
        ("evaluations", |row| row.counts.evaluations.to_string()),
        ("assemblies", |row| row.assemblies.to_string()),
        ("factorisations", |row| {
            row.counts.factorisations.to_string()
        }),
        ("changes of chart", |row| {
            row.counts.chart_changes.to_string()
        }),
        ("time / s", |row| short(row.seconds)),
    ];
    if !alone.is_empty() {
        columns.push(("alone / s", |row| known(row.seconds_alone)));
    }
    let names: Vec<&str> = columns.iter().map(|column| column.0).collect();
    let cells = |row: &ComparisonRow| columns.iter().map(|column| column.1(row)).collect();
    run_table(out, &caption, &names, &c.rows, |row| Some(cells(row)));
}

/// Assemblies before the first step, which are not counted.
fn searching(c: &Comparison) -> String {
    let before = " Not counted are assemblies before the first step, once in a run, that find what a scheme \
                  has to know (invariants of the motion, the largest frequency): ";
    let count = |row: &ComparisonRow| format!("{} {}", escaped(&row.scheme), row.searching);
    let rows = c.rows.iter().filter(|row| row.searching > 0);
    listed(before, rows.map(count))
}

pub(super) fn failures(out: &mut Page, c: &Comparison) {
    if c.rows.iter().all(|row| row.failure.is_none()) {
        return;
    }
    out.heading(2, "", "Runs without an end");
    out.table("", &["scheme", "h", "reason"], 3);
    for (failed, reason) in failures_of(c) {
        let reason = format!("<span class=\"reason\">{}</span>", escaped(reason));
        let steps: Vec<String> = failed.iter().map(|row| exact(row.step)).collect();
        let steps = match failed.len() == c.of(&failed[0].scheme).count() && failed.len() > 1 {
            true => "all".to_owned(),
            false => steps.join(", "),
        };
        out.row(false, 3, &[escaped(&failed[0].scheme), steps, reason]);
    }
    out.end_table();
}
