//! `pullback gallery`.

use super::{Exit, FAILED, print, refuse};
use crate::studies::gallery::{self, CaseRow};
use crate::terminal::{self, ProgressLine, tell};
use std::path::Path;

/// The cases by name, for the help.
pub(super) fn cases() -> String {
    let names: Vec<&str> = gallery::case_names().collect();
    format!("Cases: {}", names.join(", "))
}

/// Computes the cases and prints the comparison; returns the exit code.
pub(super) fn gallery(cases: &[String], json: bool, out: Option<&Path>) -> Exit {
    let progress = ProgressLine::new(json);
    let ran = gallery::run(cases, out, &mut |case| progress.say(case));
    progress.clear();
    let rows = ran.map_err(refuse)?;
    if out.is_some_and(|out| !out.exists()) {
        tell("note: none of these cases draws a plot");
    }
    let (text, code) = answer(&rows, json)?;
    Ok(code.max(print(&text)))
}

/// The output and the exit code, which is 0 only if every row is within its tolerance.
///
/// # Errors
/// The exit code if the rows cannot be encoded as JSON.
pub fn answer(rows: &[CaseRow], json: bool) -> Result<(String, u8), u8> {
    let text = match json {
        true => super::json("the rows", &rows)?,
        false => terminal::table(rows),
    };
    let passed = rows.iter().all(CaseRow::passed);
    Ok((text, if passed { 0 } else { FAILED }))
}
