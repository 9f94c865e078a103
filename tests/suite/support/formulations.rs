//! The page of docs/formulations.md, its commands and the tables that they have left.

use crate::support::program::{read, repository};

/// The page.
pub const PAGE: &str = include_str!("../../../docs/formulations.md");

/// Where the results lie that the page shows.
pub fn results(name: &str) -> String {
    let all = repository("docs/formulations");
    read(all.join(name).join("compare.md"))
}

/// The first table under a heading, its lines.
pub fn table<'a>(text: &'a str, heading: &str) -> Vec<&'a str> {
    let found = text.split_once(&format!("\n## {heading}\n"));
    let (_, text) = found.unwrap_or_else(|| panic!("no heading {heading}"));
    let lines = text.lines().skip_while(|line| !line.starts_with('|'));
    lines.take_while(|line| line.starts_with('|')).collect()
}

/// The commands that the page shows.
pub fn commands() -> Vec<&'static str> {
    let lines = PAGE
        .lines()
        .filter(|line| line.starts_with("pullback compare "));
    lines.collect()
}

/// Cells of a row in Markdown.
pub fn cells(line: &str) -> Vec<String> {
    let line = line.replace("\\|", "¦");
    let cells = line.trim_matches('|').split('|');
    cells.map(|c| c.trim().replace('¦', "|")).collect()
}

/// A text with the raised digits of powers of ten as exponents.
pub fn plain(text: &str) -> String {
    let text = text.replace("·10<sup>", "e").replace("</sup>", "");
    text.replace('−', "-")
}
