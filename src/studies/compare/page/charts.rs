//! The table of the cost of chart changes.

use super::{Page, begun, escaped, first, step};
use crate::studies::compare::tables::short;
use crate::studies::compare::{Comparison, ComparisonRow, ErrorQuantity};

/// Errors beside those of runs with charts that are kept longer.
const SHOWN: [ErrorQuantity; 4] = [
    ErrorQuantity::Position,
    ErrorQuantity::Rotation,
    ErrorQuantity::AngularVelocity,
    ErrorQuantity::Energy,
];

pub(super) fn charts(out: &mut Page, c: &Comparison) {
    if c.charts.is_empty() {
        return;
    }
    out.heading(2, "", "What changes of chart cost");
    let caption = "The same runs twice: with charts of rotations that change at half a turn, as in all other \
                   tables, and (after the stroke) with charts kept until three quarters of a turn, or for good \
                   where no rotation comes so far. Changes of chart, errors, and the largest defect of the \
                   balance of energy over the largest energy. Of total rotation vectors the scheme adds in \
                   other coordinates, which is another error of the same order; increments are centred anew \
                   in every step, which is what their changes are. Elements that interpolate \
                   total rotation vectors in space are others in the other chart, by the error of the mesh: the two \
                   motions are not the same, and errors after the stroke, against the reference of the \
                   first, have a floor that no step makes smaller.";
    let changes = |row: &ComparisonRow| row.counts.chart_changes;
    if c.rows.iter().chain(&c.charts).all(|row| changes(row) == 0) {
        out.paragraph("", "No run changes a chart, so there is no cost.");
        return;
    }
    let errors = SHOWN.map(|q| q.name().to_owned());
    let columns: Vec<String> = (["scheme", "h", "changes"].map(str::to_owned).into_iter())
        .chain(errors)
        .chain(["balance of energy, relative".to_owned()])
        .collect();
    out.table(caption, &columns, 1);
    let rows = begun(&c.rows);
    let late = begun(&c.charts);
    for (k, row) in rows.iter().enumerate() {
        let twin = |late: &&&ComparisonRow| late.scheme == row.scheme && late.step == row.step;
        let Some(late) = late.iter().find(twin) else {
            continue;
        };
        let both = |of: &dyn Fn(&ComparisonRow) -> Option<f64>| {
            let [a, b] = [row, late].map(|r| of(r).map_or("–".to_owned(), short));
            format!("{a} / {b}")
        };
        let mut line = vec![escaped(&row.scheme), step(row)];
        let [a, b] = [row, late].map(|r| r.counts.chart_changes);
        line.push(format!("{a} / {b}"));
        line.extend(SHOWN.map(|q| both(&|r| Some(r.error?.of(q)))));
        line.push(both(&|r| r.drift.relative(r.drift.balance)));
        out.row(first(&rows, k), 1, &line);
    }
    out.end_table();
}
