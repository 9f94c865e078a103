//! A gate of `.ci/run`: is docs/formulations.md up to date? Its commands, or cheaper ones for the same rows,
//! have to give the numbers that it prints. This is no test of what is right: the page is the program's own
//! earlier output. Orders, errors and energies are held to theory and to publications elsewhere.

use crate::support::formulations::{cells, commands, plain, results, table};
use crate::support::program::{directory, printed, read};

/// A model, its step sizes in place of those of the command where not all are made (the largest ones), and whether
/// it is flexible: small differences grow over its long run, so that of what it keeps only powers of ten are told.
type Part = (&'static str, Option<&'static str>, bool);

const PARTS: [Part; 5] = [
    ("top", None, false),
    ("free_body", None, false),
    ("elbow", None, true),
    ("smooth_arm", None, true),
    ("arm_spherical", Some("0.5x,0.25x"), true),
];

/// The tables that are made anew of flexible models, and those of all others besides.
const TABLES: [&str; 4] = [
    "Errors",
    "Cost",
    "What the motion keeps",
    "What a long run keeps",
];
const MORE: [&str; 3] = [
    "Orders of convergence",
    "Errors at equal work",
    "What changes of chart cost",
];

#[test]
fn all_models_of_the_page_are_compared() {
    let mut all: Vec<String> = commands().iter().map(|c| name_of(c).to_owned()).collect();
    all.sort();
    let mut seen = PARTS.map(|part| part.0.to_owned());
    seen.sort();
    assert_eq!(all, seen);
}

#[test]
fn top() {
    up_to_date(PARTS[0]);
}

#[test]
fn free_body() {
    up_to_date(PARTS[1]);
}

#[test]
fn elbow() {
    up_to_date(PARTS[2]);
}

#[test]
fn smooth_arm() {
    up_to_date(PARTS[3]);
}

#[test]
fn arm_spherical() {
    up_to_date(PARTS[4]);
}

/// Where a command of the page leaves its results.
fn name_of(command: &str) -> &str {
    command.rsplit_once("--out ").unwrap().1
}

/// Compares tables made anew with those of the page.
fn up_to_date(part: Part) {
    let (name, steps, flexible) = part;
    let command = commands().into_iter().find(|c| name_of(c) == name);
    let found = made_anew(&cheaper(command.unwrap(), steps), name);
    let printed = results(name);
    let more = if flexible { &[][..] } else { &MORE };
    for heading in TABLES.iter().chain(more) {
        let [a, b] = [&found, &printed].map(|text| table(text, heading));
        assert!(steps.is_some() || a.len() == b.len(), "{heading}");
        compare_tables(part, heading, [&a, &b]);
    }
}

/// A command of the page with these steps, and without times, which are not compared.
fn cheaper(command: &str, steps: Option<&str>) -> String {
    let words = command.split(' ').filter(|word| *word != "--timed");
    let mut words: Vec<&str> = words.collect();
    let at = words.iter().position(|word| *word == "--steps").unwrap() + 1;
    if let Some(steps) = steps {
        assert!(words[at].starts_with(&format!("{steps},")), "{command}");
        words[at] = steps;
    }
    words.join(" ")
}

/// Makes what a command leaves, in a directory of a test: its tables.
fn made_anew(command: &str, name: &str) -> String {
    let out = directory(&format!("formulations_{name}"));
    // Models that are files lie in docs/formulations.
    let words = command.split(' ').skip(1);
    let words = words.map(|word| match word.ends_with(".toml") {
        true => format!("{}/{word}", env!("CARGO_MANIFEST_DIR")),
        false => word.to_owned(),
    });
    let words: Vec<String> = words.collect();
    printed(&out, &words.join(" "));
    read(out.join(name).join("compare.md"))
}

/// Numbers of a cell: powers of ten are in raised digits. Of an order the slope; its confidence is scatter.
fn numbers(heading: &str, cell: &str) -> Vec<f64> {
    let text = plain(cell);
    let text = match heading.starts_with("Orders") {
        true => text.split(" ±").next().unwrap_or(&text),
        false => &text,
    };
    let parts = text.split(|c: char| !(c.is_ascii_alphanumeric() || "+-.".contains(c)));
    parts.filter_map(|part| part.parse().ok()).collect()
}

/// How many of the first cells name a row.
fn keys(heading: &str) -> usize {
    match heading {
        "Errors" => 3,
        "Errors at equal work" => 1,
        _ => 2,
    }
}

/// How far a number may be from that on the page: five in a hundred, or ten times the number where it is a
/// difference of nearly equal ones (trends, balances), what iterations leave, or the end of an irregular motion.
fn agree(flexible: bool, heading: &str, column: &str, [found, printed]: [f64; 2]) -> bool {
    let long = heading == "What a long run keeps";
    let rest =
        (long || column.contains("balance") || column.contains("trend")) && printed.abs() < 1e-3;
    match rest || (long && flexible) {
        true => found.abs() < 10.0 * printed.abs() && printed.abs() < 10.0 * found.abs(),
        false => (found - printed).abs() <= 0.05 * printed.abs(),
    }
}

/// Compares a table with the one on the page; rows are found by their first cells.
fn compare_tables((name, steps, flexible): Part, heading: &str, [found, printed]: [&[&str]; 2]) {
    let (head, keys) = (cells(printed[0]), keys(heading));
    for line in &found[2..] {
        let found = cells(line);
        let what = format!("{name}, {heading}: {line}");
        let same = |line: &&&str| cells(line)[..keys] == found[..keys];
        let printed = printed.iter().find(same);
        let printed = cells(printed.unwrap_or_else(|| panic!("{what}")));
        for (k, column) in head.iter().enumerate().skip(keys) {
            // The reference of larger steps is a coarser one, and knows less.
            let pair = || [&found[k], &printed[k]].into_iter();
            let unknown = |cell: &String| cell == "–" || cell.contains("&lt;");
            if column.ends_with("/ s") || (steps.is_some() && pair().any(unknown)) {
                continue;
            }
            let [a, b] = [&found[k], &printed[k]].map(|cell| numbers(heading, cell));
            assert_eq!(a.len(), b.len(), "{what}: {column}");
            for (a, b) in a.into_iter().zip(b) {
                let agree = agree(flexible, heading, column, [a, b]);
                assert!(agree, "{what}: {column}: {a} and not {b}");
            }
        }
    }
}
