//! `compare.html`: one page that needs nothing else, for the screen and for print.

use super::figures::Figure;
use super::order::{ABOVE_REFERENCE, STRAIGHT};
use super::tables::{order, short, status, theory};
use super::{Comparison, Kept, Quantity, Reference, Row};
use std::fmt::Write;

const STYLE: &str = "\
body{font:15px/1.45 'DejaVu Sans',Verdana,sans-serif;color:#222;max-width:1080px;margin:2em auto;\
padding:0 1em}\
h1{font-size:1.6em;margin:0 0 .2em}h2{font-size:1.2em;margin:1.8em 0 .5em}\
p{margin:.5em 0}code{font-family:'DejaVu Sans Mono',monospace;font-size:.92em}\
.command{background:#f3f3f3;padding:.5em .8em;overflow-wrap:anywhere}\
.warning{border-left:4px solid #d55e00;padding:.3em .8em;background:#fdf3ec}\
table{border-collapse:collapse;font-size:.86em;margin:.6em 0}\
p.caption{font-size:.88em;color:#444;break-after:avoid}sup{line-height:0}small{color:#666}\
th,td{padding:.22em .7em;text-align:right;white-space:nowrap;vertical-align:top}\
th{border-bottom:1px solid #444;font-weight:600;white-space:normal;vertical-align:bottom}thead tr:first-child th{border-top:1.5px solid #444}\
tbody tr:last-child td{border-bottom:1.5px solid #444}\
td.l,th.l{text-align:left}tr.next td{border-top:1px solid #ccc}td.reason{white-space:pre-wrap;\
text-align:left;color:#a33c00}\
figure{margin:1.2em 0;break-inside:avoid}figure svg{max-width:100%;height:auto}\
figcaption{font-size:.9em;color:#444}\
@page{size:A4;margin:15mm}\
@media print{body{font-size:10pt;max-width:none;margin:0;padding:0}table{font-size:7.5pt}\
th,td{padding:.12em .45em}h2{break-after:avoid}tr{break-inside:avoid}}";

/// The page with its figures inside.
pub(super) fn html(comparison: &Comparison, figures: &[Figure]) -> String {
    let mut out = String::new();
    let title = comparison.title.as_deref().unwrap_or(&comparison.model);
    let title = escaped(title);
    put(
        &mut out,
        &format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<title>{title}: \
             schemes compared</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>"
        ),
    );
    head(&mut out, comparison);
    if let Some(reference) = &comparison.reference {
        put(&mut out, "<h2>Orders of convergence</h2>");
        orders(&mut out, comparison);
        describe(&mut out, reference);
    }
    for figure in figures {
        let Figure { caption, svg, .. } = figure;
        put(
            &mut out,
            &format!(
                "<figure>\n{}\n<figcaption>{caption}</figcaption>\n</figure>",
                inline(svg)
            ),
        );
    }
    put(&mut out, "<h2>Errors</h2>");
    errors(&mut out, comparison);
    put(&mut out, "<h2>Cost</h2>");
    cost(&mut out, comparison);
    put(&mut out, "<h2>What the motion keeps</h2>");
    drift(&mut out, comparison);
    failures(&mut out, comparison);
    put(&mut out, "</body>\n</html>");
    out
}

/// Appends a line.
fn put(out: &mut String, line: &str) {
    out.push_str(line);
    out.push('\n');
}

fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;").replace('"', "&quot;")
}

/// A figure as part of a page: without its declaration.
fn inline(svg: &str) -> &str {
    svg.find("<svg")
        .map_or(svg, |start| svg[start..].trim_end())
}

fn head(out: &mut String, c: &Comparison) {
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
    if let Some(command) = &c.command {
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

fn orders(out: &mut String, c: &Comparison) {
    let columns: Vec<String> = (["scheme", "theory"].map(str::to_owned).into_iter())
        .chain(names())
        .collect();
    let caption = format!(
        "Slope of log error over log step by least squares, ± half of its 95 % confidence interval \
         (Student), and the number of step sizes in the asymptotic range: from the two \
         finest on while slopes between neighbours differ by at most {STRAIGHT}, errors below {} \
         times the error of the reference and runs with rejected steps left out. A line through two \
         points has no interval.",
        ABOVE_REFERENCE as usize
    );
    table(out, &caption, &columns, 1);
    for scheme in &c.orders {
        let mut row = vec![escaped(&scheme.scheme), theory(scheme.theory).replace('-', "–")];
        row.extend(scheme.observed.map(|o| match o {
            None => "–".to_owned(),
            Some(o) => format!(
                "{}<br/><small>{} steps</small>",
                escaped(&order(&o)),
                o.points
            ),
        }));
        cells(out, false, 1, &row);
    }
    end_table(out);
    formulations(out, c);
}

/// What the rotations are in each scheme, where they are not the same in all.
fn formulations(out: &mut String, c: &Comparison) {
    let first = c.orders.first().map(|o| o.formulation);
    if c.orders.iter().all(|o| Some(o.formulation) == first) {
        return;
    }
    put(
        out,
        "<p>Rotations of frames are unknowns in these formulations:</p>\n<ul>\n",
    );
    for scheme in &c.orders {
        let line = format!(
            "<li><code>{}</code>: {}</li>\n",
            escaped(&scheme.scheme),
            escaped(scheme.formulation)
        );
        put(out, &line);
    }
    put(out, "</ul>\n");
}

fn describe(out: &mut String, r: &Reference) {
    let [a, b, c] = r.steps;
    if c == 0.0 {
        let name = escaped(&r.scheme);
        put(
            out,
            &format!(
                "<p>Errors are those against a solution that is given: <code>{name}</code>, which knows \
                 the quantities that have errors below.</p>"
            ),
        );
        return;
    }
    put(
        out,
        &format!(
            "<p>Reference: <code>{}</code> with step sizes A = {}, B = {} and C = {}. A quantity \
             whose observed order is that in theory is extrapolated from B and C after Richardson, \
             and the estimate of its error is twice the distance from the extrapolation of A and B. {} \
             evaluations, {} changes of chart in C.</p>",
            escaped(&r.scheme),
            exact(a),
            exact(b),
            exact(c),
            r.evaluations,
            r.chart_changes
        ),
    );
    let columns: Vec<String> = std::iter::once(String::new()).chain(names()).collect();
    table(out, "The reference's own error", &columns, 1);
    let row = |name: &str, value: &dyn Fn(Quantity) -> String| {
        let values = Quantity::ALL.into_iter().map(value);
        std::iter::once(name.to_owned())
            .chain(values)
            .collect::<Vec<_>>()
    };
    let observed = row("observed order", &|q| match r.order.of(q) {
        order if order.is_finite() => format!("{order:.2}"),
        _ => "–".to_owned(),
    });
    cells(out, false, 1, &observed);
    let extrapolated = row("extrapolated", &|q| {
        if r.extrapolated[q as usize] {
            "yes"
        } else {
            "no"
        }
        .to_owned()
    });
    cells(out, false, 1, &extrapolated);
    cells(
        out,
        false,
        1,
        &row("error (rms)", &|q| short(r.error.of(q))),
    );
    end_table(out);
}

/// Whether a row is the first of its scheme.
fn first(c: &Comparison, k: usize) -> bool {
    k > 0 && c.rows[k].scheme != c.rows[k - 1].scheme
}

fn errors(out: &mut String, c: &Comparison) {
    let columns: Vec<String> = (["scheme", "h", ""].map(str::to_owned).into_iter())
        .chain(names())
        .collect();
    let caption = format!(
        "Root mean square errors over {} equally spaced times and all frame nodes; of rotations the \
         angle of the relative rotation in radians. Where the error is below that of the reference \
         itself, that stands instead.{}",
        c.times,
        changed_steps(c)
    );
    table(out, &caption, &columns, 1);
    for (k, row) in c.rows.iter().enumerate() {
        let mut line = vec![escaped(&row.scheme), step(row), note(row).to_owned()];
        // An error below that of the reference is only known to be no larger than that.
        let least = |q| c.reference.as_ref().map_or(0.0, |r| r.error.of(q));
        let error = |q| match row.error.map(|e| e.of(q)) {
            None => "–".to_owned(),
            Some(error) if error < least(q) => format!("&lt; {}", short(least(q))),
            Some(error) => short(error),
        };
        line.extend(Quantity::ALL.map(error));
        cells(out, first(c, k), 1, &line);
    }
    end_table(out);
}

fn step(row: &Row) -> String {
    exact(row.step)
}

/// Which step sizes were made of those asked for, where they are others.
fn changed_steps(c: &Comparison) -> String {
    let mut made: Vec<String> = Vec::new();
    for row in &c.rows {
        if (row.step - row.asked).abs() > 1e-9 * row.asked {
            let pair = format!("{} for {}", exact(row.step), exact(row.asked));
            if !made.contains(&pair) {
                made.push(pair);
            }
        }
    }
    if made.is_empty() {
        return String::new();
    }
    format!(
        " Steps end at kinks of the functions of time and at common times: h is {}.",
        made.join(", ")
    )
}

/// A step size with all its digits where they are few.
fn exact(h: f64) -> String {
    let all = h.to_string();
    if all.len() <= 9 { all } else { short(h) }
}

/// What there is to say about a run, in a word.
fn note(row: &Row) -> &'static str {
    match status(row) {
        "complete" if row.counts.rejected > 0 => "steps halved",
        "complete" => "",
        other => other,
    }
}

fn cost(out: &mut String, c: &Comparison) {
    let columns = [
        "scheme",
        "h",
        "steps",
        "rejected",
        "solutions per step",
        "evaluations",
        "factorisations",
        "changes of chart",
        "time / s",
        "alone / s",
    ];
    let beside = match c.threads {
        1 => "one run at a time".to_owned(),
        n => format!("{n} runs side by side on one machine, which makes each of them slower"),
    };
    let caption = format!(
        "Time is wall-clock time with the audits of energy and momentum, {beside}; alone, where it was \
         taken, that of the integration and nothing else, the least of some repetitions."
    );
    table(out, &caption, &columns.map(str::to_owned), 1);
    for (k, row) in c.rows.iter().enumerate() {
        let n = &row.counts;
        let per_step = match n.steps {
            0 => "–".to_owned(),
            _ => format!("{:.2}", row.iterations_per_step()),
        };
        let line = [
            escaped(&row.scheme),
            step(row),
            n.steps.to_string(),
            n.rejected.to_string(),
            per_step,
            n.evaluations.to_string(),
            n.factorisations.to_string(),
            n.chart_changes.to_string(),
            short(row.seconds),
            row.seconds_alone.map_or("–".to_owned(), short),
        ];
        cells(out, first(c, k), 1, &line);
    }
    end_table(out);
}

fn drift(out: &mut String, c: &Comparison) {
    let kept = c.reference.as_ref().map(|r| r.kept).unwrap_or_default();
    let constraints = if c.enforced {
        "Loops closed by multipliers hold their equations |h| at every step to the tolerance of the \
         solver, those closed by a penalty to its compliance; their rates are not enforced."
    } else {
        "Constraints are maps x = φ(t, q): they hold at every step whatever the scheme. Where loops are \
         closed by their equations, |h| is what Newton's method leaves of them at a given q."
    };
    put(out, &format!("<p>{} {constraints}</p>", keeps(&kept)));
    let columns = [
        "scheme",
        "h",
        "energy",
        "momentum",
        "angular momentum",
        "|h|",
        "balance of energy",
    ];
    let caption = "Largest change since the start at common times, of what is kept; the largest \
                   |h| at common times, each equation over its size; and the largest \
                   defect of the balance of energy over all steps, kinetic and stored less supplied \
                   (the work by the trapezoidal rule).";
    table(out, caption, &columns.map(str::to_owned), 1);
    for (k, row) in c.rows.iter().enumerate() {
        let optional = |x: Option<f64>| x.map_or("–".to_owned(), short);
        let line = [
            escaped(&row.scheme),
            step(row),
            optional(row.drift.energy),
            optional(row.drift.momentum),
            optional(row.drift.angular_momentum),
            optional(row.drift.violation),
            optional(row.counts.energy.map(|e| e.largest_defect)),
        ];
        cells(out, first(c, k), 1, &line);
    }
    end_table(out);
}

/// What a motion keeps, in words.
fn keeps(kept: &Kept) -> String {
    let components = |name: &str, which: [bool; 3]| {
        let numbers: Vec<String> = (0..3)
            .filter(|&i| which[i])
            .map(|i| format!("{}", i + 1))
            .collect();
        match numbers.len() {
            0 => None,
            3 => Some(name.to_owned()),
            _ => Some(format!("{name} (component {})", numbers.join(", "))),
        }
    };
    let all = [
        kept.energy.then(|| "energy".to_owned()),
        components("momentum", kept.momentum),
        components("angular momentum", kept.angular_momentum),
    ];
    let all: Vec<String> = all.into_iter().flatten().collect();
    match all.is_empty() {
        true => "The reference keeps neither energy nor momentum.".to_owned(),
        false => format!("The reference keeps {}.", all.join(", ")),
    }
}

fn failures(out: &mut String, c: &Comparison) {
    if c.rows.iter().all(|row| row.failure.is_none()) {
        return;
    }
    put(out, "<h2>Runs without an end</h2>");
    let columns = ["scheme", "h", "reason"].map(str::to_owned);
    table(out, "", &columns, 3);
    for row in &c.rows {
        if let Some(failure) = &row.failure {
            let line = format!(
                "<tr><td class=\"l\">{}</td><td class=\"l\">{}</td><td class=\"reason\">{}</td></tr>",
                escaped(&row.scheme),
                step(row),
                escaped(failure)
            );
            put(out, &line);
        }
    }
    end_table(out);
}
