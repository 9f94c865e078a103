//! What `pullback gallery` prints, draws and returns.

use crate::support::drawings;
use crate::support::program::*;
use pullback::cli::gallery::answer;
use pullback::studies::gallery::{CaseRow, case_names};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

#[test]
fn the_rows_as_json_have_exactly_the_keys_documented() {
    let said = printed(Path::new("."), "gallery bend45 --json");
    let rows: Vec<Value> = serde_json::from_str(&said).unwrap();
    assert!(!rows.is_empty());
    let keys = "case quantity computed published difference tolerance source seconds";
    let keys: BTreeSet<&str> = keys.split(' ').collect();
    for row in &rows {
        let object = row.as_object().unwrap();
        let found: BTreeSet<&str> = object.keys().map(String::as_str).collect();
        assert_eq!(found, keys);
        assert_eq!(row["case"], "bend45");
        assert!(!row["source"].as_str().unwrap().is_empty());
        let number = |key: &str| row[key].as_f64().unwrap();
        let difference = number("computed") - number("published");
        assert!((number("difference") - difference).abs() < 1e-12, "{row}");
        assert!(difference.abs() <= number("tolerance"), "{row}");
        assert!(number("seconds") > 0.0);
    }
}

#[test]
fn the_table_has_a_line_for_each_row() {
    let text = printed(Path::new("."), "gallery bend45 rollup");
    let lines: Vec<&str> = text.lines().collect();
    let columns: Vec<&str> = lines[0].split_whitespace().collect();
    let expected = "case quantity computed published difference tolerance source";
    assert_eq!(columns.join(" "), expected);
    // Two lines after the rows tell of times and of the number of comparisons.
    let (rows, rest) = lines[1..].split_at(lines.len() - 3);
    assert!(rest[0].starts_with("time: bend45 "), "{text}");
    let of = ["bend45  ", "rollup  "].map(|c| rows.iter().filter(|r| r.starts_with(c)).count());
    assert_eq!(of[0] + of[1], rows.len(), "{text}");
    assert!(of[0] > 0 && of[1] > 0, "{text}");
    let sum = format!("{} comparisons in 2 cases, 0 off", rows.len());
    assert!(rest[1].starts_with(&sum), "{text}");
    let right = ["  ok  exact", "  ok  published"];
    for row in rows {
        assert!(right.iter().any(|words| row.contains(words)), "{row}");
    }
}

#[test]
fn the_helix_is_drawn_as_load_against_displacement() {
    let out = directory("program_gallery");
    printed(&out, "gallery helix --out .");
    assert_eq!(files(&out), ["helix.svg"]);
    drawings::check("helix", &read(out.join("helix.svg")));
}

#[test]
fn the_gallery_page_shows_what_is_drawn_now() {
    let images = repository("docs/images");
    let mut count = 0;
    for case in drawings::cases() {
        let image = images.join(format!("{case}.svg"));
        if image.exists() {
            drawings::check(case, &read(image));
            count += 1;
        }
    }
    assert_eq!(count, 5);
}

#[test]
fn an_unknown_case_is_refused_with_the_list() {
    let output = program_in(Path::new("."), "gallery bend46");
    let said = ended(&output, 2);
    assert!(output.stdout.is_empty());
    let words = "there is no case bend46; known cases: ";
    let (_, list) = said.split_once(words).unwrap();
    let known: Vec<&str> = list.trim().split(", ").collect();
    assert!(known.into_iter().eq(case_names()));
}

fn row(difference: f64) -> CaseRow {
    CaseRow {
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
            (1.1e-3, 1),
            (-1.1e-3, 1),
            (f64::NAN, 1),
        ] {
            let rows = [row(0.0), row(difference), row(0.0)];
            let (text, said) = answer(&rows, json).unwrap();
            assert_eq!(said, code, "{difference}: {text}");
            // The table marks the row and counts it.
            if !json {
                let marked = text.matches("  NO  exact").count();
                assert_eq!(marked, usize::from(code), "{text}");
                let sum = format!("3 comparisons in 1 cases, {code} off");
                assert_says(&text, &[&sum]);
            }
        }
    }
}
