//! docs/theory.md leads to code that is there.

use crate::support::program::{read, repository};
use std::path::Path;

/// The text of a file, or of all files of a directory.
pub(super) fn text(path: &Path) -> String {
    if !path.is_dir() {
        return read(path);
    }
    let entries = std::fs::read_dir(path).unwrap();
    entries.map(|e| text(&e.unwrap().path())).collect()
}

#[test]
fn every_equation_leads_to_a_function_and_a_test() {
    let page = read(repository("docs/theory.md"));
    let (equations, table) = page.split_once("| equation |").unwrap();
    let mut led = Vec::new();
    for row in table.lines().skip(2).take_while(|l| l.starts_with('|')) {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let [numbers, functions, file, test] = cells[..] else {
            panic!("four columns: {row}");
        };
        led.extend(numbers.split(", "));
        assert!(repository(test).is_file(), "no file {test}");
        let code = text(&repository(file));
        for name in functions.split(", ").map(|f| f.trim_matches('`')) {
            let kinds = ["fn", "struct", "trait"].map(|kind| format!("{kind} {name}"));
            let ends = |c: char| !c.is_alphanumeric() && c != '_';
            let defined = kinds.iter().any(|item| {
                let after = |(k, _): (usize, &str)| code[k + item.len()..].starts_with(ends);
                code.match_indices(item.as_str()).any(after)
            });
            assert!(defined, "{name} is not defined in {file}");
        }
    }
    for k in 1..=led.len() {
        let number = format!("({k})");
        assert!(equations.contains(&number), "no equation {number}");
        assert!(led.contains(&number.as_str()), "{number} leads nowhere");
    }
}
