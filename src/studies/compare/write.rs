//! The files of a comparison.

use super::figures::{Figure, figures};
use super::page::{Format, page};
use super::perform::{self, prepare};
use super::{CompareError, Comparison, ComparisonOptions, Hooks, Maker, over_time, tables};
use crate::output::{Directory, OutputError, drawing};
use std::path::Path;

/// Name of the file that tells whether a comparison is complete.
const NAME: &str = "compare.json";
/// Name of the page.
const PAGE: &str = "compare.html";
/// Name of the page in Markdown.
const TEXT: &str = "compare.md";

/// Names of all files that a comparison may write.
pub const FILES: [&str; 9] = [
    NAME,
    "compare.csv",
    "drift.csv",
    PAGE,
    TEXT,
    "convergence.svg",
    "work.svg",
    "drift.svg",
    "iterations.svg",
];

/// Compares schemes and writes `compare.json`, `compare.csv`, `drift.csv`, the figures, the self-contained
/// `compare.html`, and the same in Markdown, `compare.md`. `command` is the command line, for the page.
///
/// An interrupted comparison keeps its results, marked incomplete.
///
/// # Errors
/// [`CompareError`]; a refused comparison leaves the directory unchanged.
pub fn run(
    make: &Maker<'_>,
    model: &str,
    command: Option<&str>,
    directory: &Path,
    options: &ComparisonOptions,
    hooks: &Hooks<'_>,
) -> Result<Comparison, CompareError> {
    let prepared = prepare(make, options).map_err(|error| error.of(model))?;
    let mut directory = Directory::open_for(directory, &FILES)?;
    let begun = serde_json::json!({ "model": model, "command": command, "complete": false });
    directory.write_json(NAME, &begun)?;
    let comparison = Comparison {
        command: command.map(str::to_owned),
        ..perform::run(make, model, options, hooks, prepared)
    };
    write(&comparison, &mut directory)?;
    Ok(comparison)
}

/// One of several models to compare on.
pub struct Subject<'a> {
    /// Name of its directory.
    pub name: String,
    /// Name of the model in the results.
    pub model: String,
    /// Builds it.
    pub make: Box<Maker<'a>>,
    /// Options of its comparison.
    pub options: ComparisonOptions,
}

/// Compares on several models in turn: each has a directory with the files of [`run`], and
/// `compare.html` beside them is one page of all.
///
/// # Errors
/// [`CompareError`]. All models are checked before the first run.
pub fn run_several(
    subjects: &[Subject<'_>],
    command: Option<&str>,
    directory: &Path,
    hooks: &Hooks<'_>,
) -> Result<Vec<Comparison>, CompareError> {
    for (k, subject) in subjects.iter().enumerate() {
        if subjects[..k].iter().any(|s| s.name == subject.name) {
            let name = subject.name.clone();
            return Err(CompareError::NameTwice { name });
        }
        prepare(&*subject.make, &subject.options).map_err(|error| error.of(&subject.model))?;
    }
    let mut all = Vec::with_capacity(subjects.len());
    for subject in subjects {
        let own = directory.join(&subject.name);
        let (make, model, options) = (&*subject.make, &subject.model, &subject.options);
        let comparison = run(make, model, command, &own, options, hooks)?;
        let complete = comparison.complete;
        all.push(comparison);
        if !complete {
            break;
        }
    }
    let sections = all.iter().map(|c| Ok((c, drawn(c)?)));
    let sections = sections.collect::<Result<Vec<_>, OutputError>>()?;
    let page = page(Format::Html, &sections);
    Directory::open_for(directory, &[PAGE])?.write(PAGE, &page)?;
    Ok(all)
}

fn drawn(comparison: &Comparison) -> Result<Vec<Figure>, OutputError> {
    figures(comparison).map_err(drawing("the figures"))
}

/// Writes all files; `compare.json`, which says whether it is complete, comes last.
fn write(comparison: &Comparison, directory: &mut Directory) -> Result<(), OutputError> {
    directory.write("compare.csv", &tables::csv(comparison))?;
    directory.write("drift.csv", &over_time::csv(comparison))?;
    let figures = drawn(comparison)?;
    for figure in &figures {
        directory.write(figure.name, &figure.svg)?;
    }
    let section = [(comparison, figures)];
    for (name, format) in [(PAGE, Format::Html), (TEXT, Format::Markdown)] {
        directory.write(name, &page(format, &section))?;
    }
    directory.write_json(NAME, comparison)
}
