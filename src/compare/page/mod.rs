//! `compare.html`: one page that needs nothing else, for the screen and for print.

mod kept;
mod orders;
mod runs;

use super::figures::Figure;
use super::tables::short;
use super::{Comparison, Quantity, Row};
use std::fmt::Write;

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
td.l,th.l{text-align:left}tr.next td{border-top:1px solid #ccc}td.reason{white-space:pre-wrap;\
text-align:left;color:#a33c00}\
figure{margin:1.2em 0;break-inside:avoid}figure svg{max-width:100%;height:auto}\
figcaption{font-size:.9em;color:#444}\
@page{size:A4;margin:15mm}\
@media print{body{font-size:10pt;max-width:none;margin:0;padding:0}table{font-size:7.5pt}\
figure{margin:.8em 0}figure svg{max-height:108mm}th,td{padding:.12em .45em}h2{break-after:avoid}tr{break-inside:avoid}}";

/// The page of comparisons, each on a model of its own, with their figures inside.
pub(super) fn html(all: &[(&Comparison, Vec<Figure>)], command: Option<&str>) -> String {
    let mut out = String::new();
    let title = match all {
        [(c, _)] => format!("{}: schemes compared", title(c)),
        _ => format!("Schemes compared on {} models", all.len()),
    };
    put(
        &mut out,
        &format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<title>{title}\
             </title>\n<style>{STYLE}</style>\n</head>\n<body>"
        ),
    );
    if all.len() > 1 {
        put(&mut out, &format!("<h1>{title}</h1>"));
    }
    for (k, (comparison, figures)) in all.iter().enumerate() {
        let class = if k > 0 { " class=\"another\"" } else { "" };
        put(
            &mut out,
            &format!("<h1{class}>{}</h1>", self::title(comparison)),
        );
        // One command made all of them.
        let command = command.filter(|_| k == 0);
        section(&mut out, comparison, figures, command);
    }
    put(&mut out, "</body>\n</html>");
    out
}

fn title(c: &Comparison) -> String {
    escaped(c.title.as_deref().unwrap_or(&c.model))
}

fn section(out: &mut String, c: &Comparison, figures: &[Figure], command: Option<&str>) {
    head(out, c, command);
    if let Some(reference) = &c.reference {
        put(out, "<h2>Orders of convergence</h2>");
        orders::orders(out, c);
        orders::describe(out, reference);
    }
    for figure in figures {
        let Figure { caption, svg, .. } = figure;
        put(
            out,
            &format!(
                "<figure>\n{}\n<figcaption>{caption}</figcaption>\n</figure>",
                inline(svg)
            ),
        );
    }
    put(out, "<h2>Errors</h2>");
    runs::errors(out, c);
    put(out, "<h2>Cost</h2>");
    runs::equal_cost(out, c);
    runs::cost(out, c);
    put(out, "<h2>What the motion keeps</h2>");
    kept::drift(out, c);
    runs::failures(out, c);
}

/// Appends a line.
fn put(out: &mut String, line: &str) {
    out.push_str(line);
    out.push('\n');
}

pub(super) fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;").replace('"', "&quot;")
}

/// A figure as part of a page: without its declaration.
fn inline(svg: &str) -> &str {
    svg.find("<svg")
        .map_or(svg, |start| svg[start..].trim_end())
}

fn head(out: &mut String, c: &Comparison, command: Option<&str>) {
    put(
        out,
        &format!(
            "<p>Schemes of time integration compared on <code>{}</code>: {} unknown{}, time from 0 to \
             {}.</p>",
            escaped(&c.model),
            c.unknowns,
            if c.unknowns == 1 { "" } else { "s" },
            c.to
        ),
    );
    if let Some(command) = command {
        put(
            out,
            &format!("<p class=\"command\"><code>{}</code></p>", escaped(command)),
        );
    }
    put(
        out,
        &format!(
            "<p>{}, {} {}.</p>",
            c.program,
            std::env::consts::OS,
            std::env::consts::ARCH
        ),
    );
    if !c.complete {
        put(
            out,
            "<p class=\"warning\">This comparison was interrupted: rows are missing or without errors.</p>",
        );
    }
    if let Some(failure) = &c.reference_failure {
        let failure = escaped(failure);
        put(
            out,
            &format!("<p class=\"warning\">There is no reference, hence no error: {failure}</p>"),
        );
    }
}

/// The head of a table: a caption, and names of columns, the first ones of words.
fn table(out: &mut String, caption: &str, columns: &[String], words: usize) {
    if !caption.is_empty() {
        put(out, &format!("<p class=\"caption\">{caption}</p>"));
    }
    put(out, "<table>");
    let mut head = String::from("<thead><tr>");
    for (k, column) in columns.iter().enumerate() {
        let class = if k < words { " class=\"l\"" } else { "" };
        // Writing to a string cannot fail.
        let _ = write!(head, "<th{class}>{column}</th>");
    }
    put(out, &format!("{head}</tr></thead>\n<tbody>"));
}

fn end_table(out: &mut String) {
    put(out, "</tbody>\n</table>");
}

/// A row of a table, the first cells of words.
fn cells(out: &mut String, next: bool, words: usize, cells: &[String]) {
    let mut row = String::from(if next { "<tr class=\"next\">" } else { "<tr>" });
    for (k, cell) in cells.iter().enumerate() {
        let class = if k < words { " class=\"l\"" } else { "" };
        let _ = write!(row, "<td{class}>{cell}</td>");
    }
    put(out, &(row + "</tr>"));
}

fn names() -> impl Iterator<Item = String> {
    Quantity::ALL.into_iter().map(|q| q.name().to_owned())
}

/// Whether a row is the first of its scheme.
fn first(rows: &[Row], k: usize) -> bool {
    k > 0 && rows[k].scheme != rows[k - 1].scheme
}

fn step(row: &Row) -> String {
    exact(row.step)
}

/// A step size with all its digits where they are few.
fn exact(h: f64) -> String {
    let all = h.to_string();
    if all.len() <= 9 { all } else { short(h) }
}
