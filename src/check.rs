//! Checks of components and models: the library's side of `pullback check MODEL.toml`.
//!
//! [`model`] checks an assembled [`Context`](crate::prelude::Context), [`job`] that of a file;
//! [`element`], [`same`], [`joint`], [`map`], [`implicit`] and [`scheme`] are the [`conformance`](crate::conformance) kit
//! for components of your own. All return a [`Report`]: [`summary`], [`table`] and [`entries`] make
//! it readable.
//!
//! ```no_run
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut job = pullback::input::load(std::path::Path::new("model.toml"))?;
//! let report = pullback::check::job(&mut job, 0);
//! print!("{}", pullback::check::table(&report));
//! # Ok(())
//! # }
//! ```

use crate::input::{Job, Plan};
use crate::terminal::longest;
use pullback_manifold::system::Events;
use serde_json::{Value, json};
use std::collections::{HashMap, HashSet};
use std::fmt::Write;

pub use pullback_conformance::{
    Block, LawRow, Measure, ModelOptions, Report, element, implicit, joint, map, model,
    parametrization, same, scheme,
};

/// Random states of a model besides its start.
const STATES: usize = 3;
/// Models with more elements than this are checked at their start and one random state.
const MANY: usize = 500;
/// Attempts to find a state that can be evaluated, each closer to the start of the analysis.
const CLOSER: usize = 3;
/// Most failures that are described in detail.
const DESCRIBED: usize = 20;

/// Checks the model of a job at the start of its analysis and at random states around it.
pub fn job(job: &mut Job, seed: u64) -> Report {
    let mut options = options(job, seed);
    let mut report = model(&mut job.context, &options);
    let nowhere = |report: &Report| {
        let mut rows = report.rows().iter();
        rows.all(|row| row.law == "domain" && row.at == "start")
    };
    // Prescribed motion may have moved too far for loops that are still at their start.
    let from = job.plan.start();
    for _ in 0..CLOSER {
        if !nowhere(&report) {
            break;
        }
        options.t = from + 0.1 * (options.t - from);
        report = model(&mut job.context, &options);
    }
    report
}

/// The state and the time at which the model of a job is checked.
///
/// The time is early in the analysis, where prescribed motion is close to its start, and lies between the kinks of
/// functions of time.
fn options(job: &Job, seed: u64) -> ModelOptions {
    let from = job.plan.start();
    let range = match &job.plan {
        Plan::Static(options) => options.to - from,
        Plan::Path(options, _) => options.load_scale,
        Plan::Dynamic(plan) => 0.1 * plan.options.to,
    };
    let kinks = job.context.kinks();
    let room = |t: f64| {
        kinks
            .iter()
            .fold(f64::INFINITY, |d, k| d.min((k - t).abs()))
    };
    // The state with the largest margin.
    let candidates = [0.37, 0.29, 0.47, 0.19, 0.61].map(|part| from + part * range);
    let t = candidates.into_iter().fold(candidates[0], |best, t| {
        if room(t) > 2.0 * room(best) { t } else { best }
    });
    ModelOptions {
        seed,
        t,
        q: job.start.q.clone(),
        states: if job.context.elements().len() > MANY {
            1
        } else {
            STATES
        },
    }
}

/// The rows of a report for JSON.
///
/// | key | |
/// |---|---|
/// | `component` | name of the component |
/// | `property` | the property that was checked |
/// | `at` | the state at which the property was closest to failing, or failed worst |
/// | `measure` | `defect`, `slope`, or `impossible` |
/// | `value` | the defect or slope; null where the property could not be checked |
/// | `limit` | the largest defect, or the smallest slope, that passes |
/// | `reason` | why the property could not be checked |
/// | `passed` | whether the property holds |
/// | `blocks` | wrong blocks, the worst first, with the fields of a [`Block`] |
pub fn entries(report: &Report) -> Vec<Value> {
    // A number that is not finite is null.
    let block = |b: &Block| {
        json!({
            "matrix": b.matrix,
            "rows": b.rows,
            "columns": b.columns,
            "defect": b.defect,
            "right": b.right,
            "factor": b.factor,
        })
    };
    let entry = |row: &LawRow| {
        let (measure, value, reason) = match &row.measure {
            Measure::Defect { defect, .. } => ("defect", Some(*defect), None),
            Measure::Slope { slope, .. } => ("slope", Some(*slope), None),
            Measure::Impossible(why) => ("impossible", None, Some(why)),
        };
        json!({
            "component": row.component,
            "property": row.law,
            "at": row.at,
            "measure": measure,
            "value": value,
            "limit": row.measure.limit(),
            "reason": reason,
            "passed": row.passed,
            "blocks": row.blocks.iter().map(block).collect::<Vec<_>>(),
        })
    };
    report.rows().iter().map(entry).collect()
}

/// A report as a table: one line for each component, with the property closest to failing and the number of properties.
/// The elements of one line of a model share a row. Failures and their wrong blocks follow.
pub fn summary(report: &Report) -> String {
    text(report, false)
}

/// Like [`summary`], with a line for each component and property.
pub fn table(report: &Report) -> String {
    text(report, true)
}

/// Rows that share a line: the one closest to failing, the components, and the number of rows.
struct Line<'a> {
    family: String,
    worst: &'a LawRow,
    components: HashSet<&'a str>,
    laws: HashSet<&'a str>,
}

impl Line<'_> {
    /// The component, or the family of components.
    fn name(&self) -> String {
        match self.components.len() {
            1 => self.worst.component.clone(),
            count => format!("{}, {count} of them", self.family),
        }
    }

    /// The property closest to failing.
    fn property(&self) -> String {
        match self.laws.len() {
            1 => self.worst.law.clone(),
            count => format!("{} (worst of {count})", self.worst.law),
        }
    }
}

/// The lines of a report: one for each family of components, or for each property of it as well.
fn lines(report: &Report, all: bool) -> Vec<Line<'_>> {
    let mut lines: Vec<Line<'_>> = Vec::new();
    let mut positions = HashMap::new();
    for row in report.rows() {
        let law = if all { row.law.as_str() } else { "" };
        let family = family(&row.component);
        let k = *positions
            .entry((family.clone(), law))
            .or_insert(lines.len());
        if k == lines.len() {
            lines.push(Line {
                family,
                worst: row,
                components: HashSet::new(),
                laws: HashSet::new(),
            });
        }
        let line = &mut lines[k];
        line.components.insert(&row.component);
        line.laws.insert(&row.law);
        if row.measure.strain() > line.worst.measure.strain() {
            line.worst = row;
        }
    }
    lines
}

/// The table of a report, its failures in detail, and the numbers of properties and failures.
fn text(report: &Report, all: bool) -> String {
    let lines = lines(report, all);
    let names: Vec<String> = lines.iter().map(Line::name).collect();
    let laws: Vec<String> = lines.iter().map(Line::property).collect();
    let first = longest(names.iter().map(|name| &**name)).max("component".len());
    let second = longest(laws.iter().map(|law| &**law)).max("property".len());
    let mut out = format!(
        "{:first$}  {:second$}  {:>15}  {:>9}\n",
        "component", "property", "measured", "limit"
    );
    let mut last = "";
    for ((name, law), line) in names.iter().zip(&laws).zip(&lines) {
        let row = line.worst;
        let shown = if name == last { "" } else { name };
        last = name;
        let (measured, limit) = match &row.measure {
            Measure::Defect { defect, allowed } => {
                (format!("defect {defect:8.1e}"), format!("<= {allowed:.0e}"))
            }
            Measure::Slope { slope, .. } => (
                format!("slope {slope:9.2}"),
                format!(">= {:.2}", row.measure.limit()),
            ),
            Measure::Impossible(_) => ("impossible".to_owned(), String::new()),
        };
        let verdict = if row.passed { "ok" } else { "FAIL" };
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "{shown:first$}  {law:second$}  {measured:>15}  {limit:>9}  {verdict}",
        );
    }
    describe_failures(&mut out, report);
    out
}

/// Writes the first failures with their wrong blocks, and the numbers of properties and failures.
fn describe_failures(out: &mut String, report: &Report) {
    let failures = report.failures();
    for row in failures.iter().take(DESCRIBED) {
        let _ = write!(out, "\nFAIL {}: {}\n", row.component, row.law);
        let _ = writeln!(out, "  at {}: {}", row.at, row.measure);
        for block in &row.blocks {
            let _ = writeln!(out, "  {block}");
        }
    }
    if failures.len() > DESCRIBED {
        let _ = writeln!(out, "\n... and {} more", failures.len() - DESCRIBED);
    }
    let components: HashSet<&str> = report.rows().iter().map(|r| r.component.as_str()).collect();
    let _ = writeln!(
        out,
        "\n{} properties of {} components, {} wrong",
        report.rows().len(),
        components.len(),
        failures.len()
    );
}

/// The common name of the elements of one line: `element arm:7 (beam)` is of `element arm:* (beam)`.
fn family(component: &str) -> String {
    let numbered = component.split_once(':').and_then(|(line, rest)| {
        let rest = rest.trim_start_matches(|c: char| c.is_ascii_digit());
        (rest.is_empty() || rest.starts_with(' ')).then(|| format!("{line}:*{rest}"))
    });
    numbered.unwrap_or_else(|| component.to_owned())
}
