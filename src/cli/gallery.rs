//! `pullback gallery`.

use super::{FAILED, REFUSED, print};
use crate::studies::gallery::{self, Comparison};
use crate::terminal::{self, Progress, tell};
use std::path::Path;

/// The cases by name, for the help.
pub(super) fn cases() -> String {
    let names: Vec<&str> = gallery::CASES.iter().map(|c| c.name).collect();
    format!("Cases: {}", names.join(", "))
}

/// Computes the cases and prints the comparison; returns the exit code.
pub(super) fn gallery(cases: &[String], json: bool, out: Option<&Path>) -> u8 {
    let progress = Progress::new(json);
    let ran = gallery::run(cases, out, &mut |case| progress.say(case));
    progress.clear();
    let rows = match ran {
        Ok(rows) => rows,
        Err(error) => {
            tell(format_args!("error: {error}"));
            return REFUSED;
        }
    };
    if out.is_some_and(|out| !out.exists()) {
        tell("note: none of these cases draws a plot");
    }
    match answer(&rows, json) {
        Ok((text, code)) => match print(&text) {
            0 => code,
            unwritten => unwritten,
        },
        Err(error) => {
            tell(format_args!("cannot encode the rows: {error}"));
            REFUSED
        }
    }
}

/// The output and the exit code, which is 0 only if every row is within its tolerance.
fn answer(rows: &[Comparison], json: bool) -> serde_json::Result<(String, u8)> {
    let text = if json {
        serde_json::to_string_pretty(rows)? + "\n"
    } else {
        terminal::table(rows)
    };
    let passed = rows.iter().all(Comparison::passed);
    Ok((text, if passed { 0 } else { FAILED }))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    fn row(difference: f64) -> Comparison {
        Comparison {
            case: "spring".to_owned(),
            quantity: "length".to_owned(),
            computed: 2.0 + difference,
            published: 2.0,
            difference,
            tolerance: 1e-3,
            source: "exact".to_owned(),
            seconds: 0.5,
        }
    }

    #[test]
    fn one_row_that_is_off_is_a_failure() {
        for json in [false, true] {
            for (difference, code) in [
                (9e-4, 0),
                (-9e-4, 0),
                (1.1e-3, FAILED),
                (-1.1e-3, FAILED),
                (f64::NAN, FAILED),
            ] {
                let rows = [row(0.0), row(difference), row(0.0)];
                let (text, said) = answer(&rows, json).unwrap();
                assert_eq!(said, code, "{difference}: {text}");
                // The table marks the row and counts it.
                let off = usize::from(code != 0);
                if !json {
                    assert_eq!(text.matches("  NO  exact").count(), off, "{text}");
                    let sum = format!("3 comparisons in 1 cases, {off} off");
                    assert!(text.contains(&sum), "{text}");
                }
            }
        }
    }
}
