//! The table of the cost of chart changes.

use super::{Page, begun, run_table};
use crate::studies::compare::tables::known;
use crate::studies::compare::{Comparison, ComparisonRow, ErrorQuantity};

/// Quantities whose errors are compared with those of runs with late changes of chart.
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
    let mut columns = vec!["changes"];
    columns.extend(SHOWN.map(ErrorQuantity::name));
    columns.push("balance of energy, relative");
    let late = begun(&c.charts);
    run_table(out, caption, &columns, &c.rows, |row| {
        let twin = |late: &&&ComparisonRow| late.scheme == row.scheme && late.step == row.step;
        let late = late.iter().find(twin)?;
        let both = |of: &dyn Fn(&ComparisonRow) -> Option<f64>| {
            let [a, b] = [row, late].map(|r| known(of(r)));
            format!("{a} / {b}")
        };
        let mut line = vec![format!("{} / {}", changes(row), changes(late))];
        line.extend(SHOWN.map(|q| both(&|r| Some(r.error?.of(q)))));
        line.push(both(&|r| r.drift.relative(r.drift.balance)));
        Some(line)
    });
}
