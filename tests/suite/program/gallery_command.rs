//! What `pullback gallery` prints, draws and returns.
#![allow(clippy::unwrap_used)]

use crate::support::program::{command, directory, files, read};
use pullback::cli::gallery::answer;
use pullback::studies::gallery::CaseRow;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

#[test]
fn the_rows_as_json_have_exactly_the_keys_documented() {
    let output = command("gallery", &["bend45".as_ref(), "--json".as_ref()]);
    assert_eq!(output.status.code(), Some(0));
    let rows: Value = serde_json::from_slice(&output.stdout).unwrap();
    let rows = rows.as_array().unwrap();
    let keys = "case quantity computed published difference tolerance source seconds";
    let keys: BTreeSet<&str> = keys.split(' ').collect();
    for row in rows {
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
    let tips: Vec<f64> = rows
        .iter()
        .filter(|r| {
            r["quantity"]
                .as_str()
                .unwrap()
                .starts_with("tip displacement")
        })
        .map(|r| r["computed"].as_f64().unwrap())
        .collect();
    // [M04] section 4.2.
    assert_eq!(tips.len(), 3);
    for (tip, published) in tips.iter().zip([-23.696, -13.668, 53.497]) {
        assert!((tip - published).abs() <= 1e-3, "{tip} for {published}");
    }
}

#[test]
fn the_table_has_a_line_for_each_row() {
    let output = command("gallery", &["bend45".as_ref(), "rollup".as_ref()]);
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let columns: Vec<&str> = lines[0].split_whitespace().collect();
    let expected = "case quantity computed published difference tolerance source";
    assert_eq!(columns.join(" "), expected);
    // Two lines after the rows tell of times and of the number of comparisons.
    let (rows, rest) = lines[1..].split_at(lines.len() - 3);
    assert!(rest[0].starts_with("time: bend45 "), "{text}");
    let of = |case: &str| rows.iter().filter(|r| r.starts_with(case)).count();
    assert_eq!(of("bend45  ") + of("rollup  "), rows.len(), "{text}");
    assert!(of("bend45  ") > 0 && of("rollup  ") > 0, "{text}");
    let sum = format!("{} comparisons in 2 cases, 0 off", rows.len());
    assert!(rest[1].starts_with(&sum), "{text}");
    for row in rows {
        assert!(
            row.contains("  ok  exact") || row.contains("  ok  published"),
            "{row}"
        );
    }
}

#[test]
fn the_helix_is_drawn_as_load_against_displacement() {
    let out = directory("program_gallery");
    let arguments = ["helix".as_ref(), "--out".as_ref(), out.as_path()];
    assert_eq!(command("gallery", &arguments).status.code(), Some(0));
    assert_eq!(files(&out), ["helix.svg"]);
    crate::support::drawings::check("helix", &read(out.join("helix.svg")));
}

#[test]
fn the_gallery_page_shows_what_is_drawn_now() {
    let images = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/images");
    let shown =
        crate::support::drawings::cases().map(|case| (case, images.join(format!("{case}.svg"))));
    let mut count = 0;
    for (case, image) in shown.filter(|(_, image)| image.exists()) {
        crate::support::drawings::check(case, &read(image));
        count += 1;
    }
    assert_eq!(count, 5);
}

#[test]
fn an_unknown_case_is_refused_with_the_list() {
    let output = command("gallery", &["bend46".as_ref()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
    let said = String::from_utf8(output.stderr).unwrap();
    let list = said
        .split_once("there is no case bend46; known cases: ")
        .unwrap()
        .1;
    let known: Vec<&str> = list.trim().split(", ").collect();
    for name in [
        "bend45",
        "helix",
        "rollup",
        "lee-frame",
        "deep-arch",
        "objectivity",
    ] {
        assert!(known.contains(&name), "{name} is not in {list}");
    }
    assert_eq!(known.len(), pullback::studies::gallery::CASES.len());
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
                assert_eq!(
                    text.matches("  NO  exact").count(),
                    usize::from(code),
                    "{text}"
                );
                let sum = format!("3 comparisons in 1 cases, {code} off");
                assert!(text.contains(&sum), "{text}");
            }
        }
    }
}
