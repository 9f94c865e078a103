//! Cells of the pages of `pullback compare` are the numbers of its JSON, to three digits.

use crate::support::formulations::{cells, plain, table};
use crate::support::program::{directory, json, printed, read};
use pullback::studies::compare::ErrorQuantity;
use serde_json::Value;

/// A number in a cell.
fn number(cell: &str) -> f64 {
    let number = plain(cell).parse();
    number.unwrap_or_else(|_| panic!("no number: {cell}"))
}

/// Whether a cell is a number rounded to three digits, or a dash where there is none.
fn is(cell: &str, value: &Value) -> bool {
    let Some(value) = value.as_f64() else {
        return cell == "–";
    };
    let unit = 10.0_f64.powf(value.abs().log10().floor() - 2.0);
    let off = (number(cell) - value).abs();
    if value == 0.0 {
        cell == "0"
    } else {
        off <= 0.5 * unit * (1.0 + 1e-9)
    }
}

/// Keys of the quantities.
fn quantities() -> impl Iterator<Item = String> {
    ErrorQuantity::ALL.into_iter().map(ErrorQuantity::key)
}

/// A page in Markdown, and what its JSON says.
struct Page {
    text: String,
    json: Value,
}

impl Page {
    /// Cells of each row of a table, and the part of the JSON that it shows.
    fn rows(&self, heading: &str, name: &str) -> impl Iterator<Item = (Vec<String>, &Value)> {
        let (lines, parts) = (table(&self.text, heading), self.json[name].as_array());
        let parts = parts.unwrap();
        assert_eq!(lines.len(), 2 + parts.len(), "{heading}");
        let cells: Vec<_> = lines[2..].iter().map(|line| cells(line)).collect();
        cells.into_iter().zip(parts)
    }
}

#[track_caller]
fn same(heading: &str, cell: &str, value: &Value) {
    assert!(is(cell, value), "{heading}: {cell} and not {value}");
}

#[test]
fn cells_of_pages_are_the_numbers_of_the_json() {
    let directory = directory("program_compare_cells");
    let asked = "compare pendulum --schemes newmark,ga:0.8,radau --steps 0.1,0.05,0.025 --long 3 -q --out out";
    printed(&directory, asked);
    let [text, html] = ["md", "html"].map(|e| read(directory.join(format!("out/compare.{e}"))));
    let json = json(directory.join("out/compare.json"));
    let counts = ["rows", "long", "orders"].map(|name| json[name].as_array().unwrap().len());
    assert_eq!(counts, [9, 3, 3]);
    let page = Page { text, json };
    errors(&page);
    costs(&page);
    kept(&page);
    orders(&page);
    html_is_alike(&page.text, &html);
}

fn errors(page: &Page) {
    for (cells, row) in page.rows("Errors", "rows") {
        assert_eq!(cells[0], row["scheme"].as_str().unwrap());
        same("h", &cells[1], &row["step"]);
        for (cell, quantity) in cells[3..].iter().zip(quantities()) {
            let errors = [&row["error"], &page.json["reference"]["error"]];
            let [error, least] = errors.map(|errors| &errors[&quantity]);
            // What is below the error of the reference is only known to be so.
            match cell.strip_prefix("&lt; ") {
                Some(cell) => {
                    assert!(error.as_f64() < least.as_f64());
                    same(&quantity, cell, least);
                }
                None => same(&quantity, cell, error),
            }
        }
    }
}

fn costs(page: &Page) {
    for (cells, row) in page.rows("Cost", "rows") {
        let counts = &row["counts"];
        for (k, value) in [
            (2, &counts["steps"]),
            (3, &counts["rejected"]),
            (5, &counts["evaluations"]),
            (6, &row["assemblies"]),
            (7, &counts["factorisations"]),
            (8, &counts["chart_changes"]),
        ] {
            assert_eq!(cells[k], value.to_string(), "{cells:?}");
        }
        let of = |name: &str| counts[name].as_f64().unwrap();
        let per_step = of("iterations") / of("steps");
        assert!((number(&cells[4]) - per_step).abs() <= 0.005 + 1e-12);
        same("time", &cells[9], &row["seconds"]);
    }
}

fn kept(page: &Page) {
    for (heading, name) in [
        ("What the motion keeps", "rows"),
        ("What a long run keeps", "long"),
    ] {
        for (cells, row) in page.rows(heading, name) {
            let drift = &row["drift"];
            let part = |name: &str| {
                let largest = drift["largest_energy"].as_f64().unwrap();
                Value::from(drift[name].as_f64().map(|x| x / largest))
            };
            assert_eq!(cells[0], row["scheme"].as_str().unwrap());
            let values = [
                row["step"].clone(),
                drift["energy"].clone(),
                part("energy"),
                drift["momentum"].clone(),
                drift["angular_momentum"].clone(),
                drift["violation"].clone(),
                drift["balance"].clone(),
                part("balance"),
                part("trend"),
            ];
            assert_eq!(cells.len(), 1 + values.len());
            for (cell, value) in cells[1..].iter().zip(&values) {
                same(heading, cell, value);
            }
        }
    }
}

fn orders(page: &Page) {
    for (cells, scheme) in page.rows("Orders of convergence", "orders") {
        assert_eq!(cells[0], scheme["scheme"].as_str().unwrap());
        for (cell, quantity) in cells[2..].iter().zip(quantities()) {
            let found = &scheme["observed"][quantity];
            let Some(slope) = found["order"].as_f64() else {
                assert_eq!(cell, "–");
                continue;
            };
            let text = cell.replace("<span class=\"slope\">(", "");
            let shown = text.split(|c: char| !(c.is_ascii_digit() || ".−".contains(c)));
            let shown = number(shown.clone().next().unwrap());
            let near = (shown - slope).abs() <= 0.005 + 1e-12;
            assert!(near, "{cell} and not {slope}");
            let steps = format!("<small>{} steps</small>", found["points"]);
            assert!(cell.contains(&steps), "{cell}");
        }
    }
}

/// The cells of the HTML are those of the Markdown.
fn html_is_alike(text: &str, page: &str) {
    let found = page.split("<td").skip(1).map(|part| {
        let (_, cell) = part.split_once('>').unwrap();
        cell.split("</td>").next().unwrap().trim().to_owned()
    });
    let found: Vec<String> = found.collect();
    let expected = text.split("\n| :--").skip(1).flat_map(|part| {
        let lines = part.lines().skip(1);
        lines
            .take_while(|line| line.starts_with('|'))
            .flat_map(cells)
    });
    assert_eq!(found, expected.collect::<Vec<String>>());
    let heads = text.lines().filter(|line| line.starts_with("| :--"));
    let heads: usize = heads.map(|line| cells(line).len()).sum();
    assert_eq!(page.matches("</th>").count(), heads);
}
