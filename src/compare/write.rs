//! What a comparison leaves in a directory.

use super::figures::figures;
use super::{CompareError, Comparison, Maker, Options, Watch, carry_out, page, prepare, tables};
use crate::output::{Directory, OutputError};
use std::path::{Path, PathBuf};

/// Name of the file that says whether a comparison is complete.
const NAME: &str = "compare.json";

/// Names of all files that a comparison may write.
pub const FILES: [&str; 7] = [
    NAME,
    "compare.csv",
    "compare.html",
    "convergence.svg",
    "work.svg",
    "drift.svg",
    "iterations.svg",
];

/// Where a comparison on a model file goes unless told otherwise: beside it, `model.compare`.
pub fn default_directory(model: &Path) -> PathBuf {
    model.with_extension("compare")
}

/// Compares schemes and writes `compare.json`, `compare.csv`, the figures and `compare.html`, which
/// needs no other file. `command` is the command line that asks for it.
///
/// A comparison that is stopped keeps what has been found, marked incomplete.
///
/// # Errors
/// [`CompareError`]; whatever is refused leaves the directory as it is.
pub fn run(
    make: &Maker<'_>,
    model: &str,
    command: Option<&str>,
    directory: &Path,
    options: &Options,
    watch: &Watch<'_>,
) -> Result<Comparison, CompareError> {
    let prepared = prepare(make, options)?;
    let mut directory = Directory::open_for(directory, &FILES)?;
    let begun = serde_json::json!({ "model": model, "command": command, "complete": false });
    directory.write(NAME, &encode(&begun)?)?;
    let comparison = Comparison {
        command: command.map(str::to_owned),
        ..carry_out(make, model, options, watch, prepared)
    };
    write(&comparison, &mut directory)?;
    Ok(comparison)
}

/// Writes all files; `compare.json`, which says whether it is complete, comes last.
fn write(comparison: &Comparison, directory: &mut Directory) -> Result<(), OutputError> {
    directory.write("compare.csv", &tables::csv(comparison))?;
    let figures = figures(comparison).map_err(|source| OutputError::Draw {
        name: "the figures".to_owned(),
        source,
    })?;
    for figure in &figures {
        directory.write(figure.name, &figure.svg)?;
    }
    directory.write("compare.html", &page::html(comparison, &figures))?;
    directory.write(NAME, &encode(comparison)?)
}

fn encode(value: &impl serde::Serialize) -> Result<String, OutputError> {
    let text = serde_json::to_string_pretty(value).map_err(|source| OutputError::Encode {
        name: NAME.to_owned(),
        source,
    })?;
    Ok(text + "\n")
}
