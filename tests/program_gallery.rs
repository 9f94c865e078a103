//! What `pullback gallery` prints, draws and returns.
#![allow(clippy::unwrap_used)]

mod program_support;

use program_support::{command, directory, files, read};
use roxmltree::{Document, Node};
use serde_json::Value;
use std::collections::BTreeSet;

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

/// Numbers of an attribute.
fn numbers(text: &str) -> Vec<f64> {
    let words = text.split([' ', ',']).filter(|w| !w.is_empty());
    words.map(|w| w.parse().unwrap()).collect()
}

/// Turns places along a drawing's axis into values, by the labels at two ticks.
fn axis(
    document: &Document<'_>,
    coordinate: &str,
    is_tick: fn(&Node<'_, '_>) -> bool,
) -> impl Fn(f64) -> f64 {
    let labels = document
        .descendants()
        .filter(|n| n.has_tag_name("text") && is_tick(n));
    let mut ticks: Vec<[f64; 2]> = labels
        .filter_map(|n| {
            let value = n.text()?.trim().replace('−', "-").parse().ok()?;
            Some([numbers(n.attribute(coordinate)?)[0], value])
        })
        .collect();
    ticks.sort_by(|a, b| a[1].total_cmp(&b[1]));
    let [[p, a], .., [q, b]] = ticks[..] else {
        panic!("{} labels along {coordinate}", ticks.len());
    };
    move |place| a + (b - a) * (place - p) / (q - p)
}

#[test]
fn the_helix_is_drawn_as_load_against_displacement() {
    let out = directory("program_gallery");
    let arguments = ["helix".as_ref(), "--out".as_ref(), out.as_path()];
    assert_eq!(command("gallery", &arguments).status.code(), Some(0));
    assert_eq!(files(&out), ["helix.svg"]);
    check_helix(&read(out.join("helix.svg")));
    // What the README shows is what is drawn now.
    check_helix(include_str!("../docs/images/helix.svg"));
}

/// Labels and curves of the drawing.
fn check_helix(text: &str) {
    let document = Document::parse(text).unwrap();
    let words: Vec<&str> = document
        .descendants()
        .filter_map(|n| n.text())
        .map(str::trim)
        .collect();
    for label in [
        "load factor",
        "tip displacement along e3",
        "100 elements",
        "200 elements",
        "100 geodesic elements",
    ] {
        assert!(words.contains(&label), "{label:?} is not among {words:?}");
    }
    let load = axis(&document, "x", |n| {
        n.attribute("dy") == Some("0.76em") && n.attribute("transform").is_none()
    });
    let height = axis(&document, "y", |n| {
        n.attribute("text-anchor") == Some("end")
    });
    // The frame has five points, ticks and the legend two.
    let lines = document
        .descendants()
        .filter(|n| n.has_tag_name("polyline"));
    let curves: Vec<Vec<(f64, f64)>> = lines
        .map(|n| numbers(n.attribute("points").unwrap()))
        .filter(|points| points.len() > 2 * 50)
        .map(|points| {
            points
                .chunks(2)
                .map(|p| (load(p[0]), height(p[1])))
                .collect()
        })
        .collect();
    assert_eq!(curves.len(), 3);
    for curve in &curves {
        // Within the lines' width: from nothing to the whole load, over the first maximum that
        // the thesis shows.
        let (first, last) = (curve[0], curve[curve.len() - 1]);
        assert!(first.0.abs() < 2e-3 && first.1.abs() < 0.02, "{first:?}");
        assert!((last.0 - 1.0).abs() < 2e-3, "{last:?}");
        let top = curve
            .iter()
            .copied()
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap();
        assert!(
            (top.0 - 0.036).abs() < 3e-3 && (top.1 - 3.28).abs() < 0.05,
            "{top:?}"
        );
    }
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
    assert_eq!(known.len(), pullback::gallery::CASES.len());
}
