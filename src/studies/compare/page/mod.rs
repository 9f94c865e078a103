//! `compare.html`: one self-contained page, for the screen and for print; and `compare.md`, the
//! same in Markdown.

mod charts;
mod conserved;
mod orders;
mod runs;
mod writer;

use super::figures::Figure;
use super::tables::short;
use super::{Comparison, ComparisonRow, ErrorQuantity};
use crate::output::plot::escaped;
use crate::terminal::plural;
use writer::Page;

pub(super) use writer::Format;

const STYLE: &str = "\
body{font:15px/1.45 'DejaVu Sans',Verdana,sans-serif;color:#222;max-width:1080px;margin:2em auto;\
padding:0 1em}\
h1{font-size:1.6em;margin:0 0 .2em}h1.another{margin-top:2.5em;break-before:page}h2{font-size:1.2em;margin:1.8em 0 .5em}\
p{margin:.5em 0}code{font-family:'DejaVu Sans Mono',monospace;font-size:.92em}\
.command{background:#f3f3f3;padding:.5em .8em;overflow-wrap:anywhere}\
.warning{border-left:4px solid #d55e00;padding:.3em .8em;background:#fdf3ec}\
table{border-collapse:collapse;font-size:.86em;margin:.6em 0}\
p.caption{font-size:.88em;color:#444;break-after:avoid}sup{line-height:0}small{color:#666}.slope{color:#767676}\
th,td{padding:.22em .7em;text-align:right;white-space:nowrap;vertical-align:top}\
th{border-bottom:1px solid #444;font-weight:600;white-space:normal;vertical-align:bottom}thead tr:first-child th{border-top:1.5px solid #444}\
tbody tr:last-child td{border-bottom:1.5px solid #444}\
td.l,th.l{text-align:left}tr.next td{border-top:1px solid #ccc}span.reason{white-space:pre-wrap;\
color:#a33c00}\
figure{margin:1.2em 0;break-inside:avoid}figure svg{max-width:100%;height:auto}\
figcaption{font-size:.9em;color:#444}\
@page{size:A4;margin:15mm}\
@media print{body{font-size:10pt;max-width:none;margin:0;padding:0}table{font-size:7.5pt}\
figure{margin:.8em 0}figure svg{max-height:108mm}th,td{padding:.12em .45em}h2{break-after:avoid}tr{break-inside:avoid}}";

/// The page of comparisons, one per model, with their figures.
pub(super) fn page(format: Format, all: &[(&Comparison, Vec<Figure>)]) -> String {
    let mut out = Page::new(format);
    let title = match all {
        [(c, _)] => format!("{}: schemes compared", title(c)),
        _ => format!("Schemes compared on {} models", all.len()),
    };
    if out.is_html() {
        out.put(&format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<title>{title}\
             </title>\n<style>{STYLE}</style>\n</head>\n<body>"
        ));
    }
    if all.len() > 1 {
        out.heading(1, "", &title);
    }
    for (k, (comparison, figures)) in all.iter().enumerate() {
        let class = if k > 0 { "another" } else { "" };
        out.heading(1, class, &self::title(comparison));
        // All of them have the same command.
        let command = comparison.command.as_deref().filter(|_| k == 0);
        section(&mut out, comparison, figures, command);
    }
    if out.is_html() {
        out.put("</body>\n</html>");
    }
    out.into_text()
}

fn title(c: &Comparison) -> String {
    escaped(c.title.as_deref().unwrap_or(&c.model))
}

fn section(out: &mut Page, c: &Comparison, figures: &[Figure], command: Option<&str>) {
    head(out, c, command);
    if let Some(reference) = &c.reference {
        out.heading(2, "", "Orders of convergence");
        orders::orders(out, c);
        orders::describe(out, c, reference);
    }
    for figure in figures {
        out.figure(figure);
    }
    out.heading(2, "", "Errors");
    runs::errors(out, c);
    for equal in c.equal_cost.iter().chain(&c.equal_time) {
        runs::equal_cost(out, equal);
    }
    out.heading(2, "", "Cost");
    runs::cost(out, c);
    conserved::drift(out, c);
    charts::charts(out, c);
    runs::failures(out, c);
}

fn head(out: &mut Page, c: &Comparison, command: Option<&str>) {
    let (model, unknowns, to) = (escaped(&c.model), plural(c.unknowns, "unknown"), c.to);
    let text = format!(
        "Schemes of time integration compared on <code>{model}</code>: {unknowns}, time from 0 to {to}."
    );
    out.paragraph("", &text);
    if let Some(command) = command {
        out.command(command);
    }
    let (system, machine) = (std::env::consts::OS, std::env::consts::ARCH);
    out.paragraph("", &format!("{}, {system} {machine}.", c.program));
    if !c.complete {
        let text = "This comparison was interrupted: rows are missing or without errors.";
        out.paragraph("warning", text);
    }
    if let Some(failure) = &c.reference_failure {
        let text = format!(
            "There is no reference, hence no error: {}",
            escaped(failure)
        );
        out.paragraph("warning", &text);
    }
}

/// The names of columns, of which the last ones are quantities with errors.
fn with_errors<'a>(first: &[&'a str]) -> Vec<&'a str> {
    let errors = ErrorQuantity::ALL.map(ErrorQuantity::name);
    first.iter().copied().chain(errors).collect()
}

/// The rows of runs that started; the others are among the failures.
fn begun(rows: &[ComparisonRow]) -> Vec<&ComparisonRow> {
    let begun = |row: &&ComparisonRow| row.failure.is_none() || !row.samples.is_empty();
    rows.iter().filter(begun).collect()
}

/// A table of the runs that started, after columns of the scheme and the step size.
fn run_table(
    out: &mut Page,
    caption: &str,
    columns: &[&str],
    rows: &[ComparisonRow],
    cells: impl Fn(&ComparisonRow) -> Option<Vec<String>>,
) {
    out.table(caption, &[&["scheme", "h"], columns].concat(), 1);
    let rows = begun(rows);
    for (k, row) in rows.iter().enumerate() {
        if let Some(cells) = cells(row) {
            let next = k > 0 && row.scheme != rows[k - 1].scheme;
            let line = [vec![escaped(&row.scheme), exact(row.step)], cells].concat();
            out.row(next, 1, &line);
        }
    }
    out.end_table();
}

/// A step size with all its digits if there are few.
fn exact(h: f64) -> String {
    let all = h.to_string();
    if all.len() <= 9 { all } else { short(h) }
}
