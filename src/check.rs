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
        Plan::Steady(..) => 0.0,
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

/// The rows of each family of components, or of each property of it as well.
fn families(report: &Report, all: bool) -> Vec<(String, Vec<&LawRow>)> {
    let mut families: Vec<(String, Vec<&LawRow>)> = Vec::new();
    let mut positions = HashMap::new();
    for row in report.rows() {
        let law = if all { row.law.as_str() } else { "" };
        let family = family(&row.component);
        let next = families.len();
        let k = *positions.entry((family.clone(), law)).or_insert(next);
        if k == next {
            families.push((family, Vec::new()));
        }
        families[k].1.push(row);
    }
    families
}

/// A line for some rows: the component or family of components, the property closest to failing, and its row.
fn line((family, rows): (String, Vec<&LawRow>)) -> Option<(String, String, &LawRow)> {
    let strain = |row: &LawRow| row.measure.strain();
    let rows = || rows.iter().copied();
    let worst = rows().reduce(|worst, row| match strain(row) > strain(worst) {
        true => row,
        false => worst,
    })?;
    let components: HashSet<_> = rows().map(|row| &row.component).collect();
    let laws: HashSet<_> = rows().map(|row| &row.law).collect();
    let name = match components.len() {
        1 => worst.component.clone(),
        count => format!("{family}, {count} of them"),
    };
    let law = match laws.len() {
        1 => worst.law.clone(),
        count => format!("{} (worst of {count})", worst.law),
    };
    Some((name, law, worst))
}

/// The table of a report, its failures in detail, and the numbers of properties and failures.
fn text(report: &Report, all: bool) -> String {
    let lines: Vec<_> = families(report, all).into_iter().filter_map(line).collect();
    let first = longest(lines.iter().map(|(name, ..)| &**name)).max("component".len());
    let second = longest(lines.iter().map(|(_, law, _)| &**law)).max("property".len());
    let mut out = format!(
        "{:first$}  {:second$}  {:>15}  {:>9}\n",
        "component", "property", "measured", "limit"
    );
    let mut last = "";
    for (name, law, row) in &lines {
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
        out += &format!("{shown:first$}  {law:second$}  {measured:>15}  {limit:>9}  {verdict}\n");
    }
    describe_failures(&mut out, report);
    out
}

/// Writes the first failures with their wrong blocks, and the numbers of properties and failures.
fn describe_failures(out: &mut String, report: &Report) {
    let failures = report.failures();
    for row in failures.iter().take(DESCRIBED) {
        *out += &format!("\nFAIL {}: {}\n", row.component, row.law);
        *out += &format!("  at {}: {}\n", row.at, row.measure);
        for block in &row.blocks {
            *out += &format!("  {block}\n");
        }
    }
    if failures.len() > DESCRIBED {
        *out += &format!("\n... and {} more\n", failures.len() - DESCRIBED);
    }
    let components: HashSet<&str> = report.rows().iter().map(|r| r.component.as_str()).collect();
    *out += &format!(
        "\n{} properties of {} components, {} wrong\n",
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
