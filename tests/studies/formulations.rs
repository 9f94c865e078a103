//! A gate of `.ci/run`: is docs/formulations.md up to date? Its commands, but for the
//! two slowest, have to give the numbers that it prints. This is no test of what is right: the page is the program's own
//! earlier output. Orders, errors and energies are held to theory and to publications elsewhere.

use crate::support::formulations::{cells, commands, plain, results, table};
use crate::support::program::{directory, printed, read};

/// The tables that are made anew of flexible models, and those of all others besides.
const TABLES: [&str; 3] = ["Errors", "Cost", "What the motion keeps"];
const MORE: [&str; 4] = [
    "What a long run keeps",
    "Orders of convergence",
    "Errors at equal work",
    "What changes of chart cost",
];

#[test]
fn top() {
    up_to_date("top", false);
}

#[test]
fn free_body() {
    up_to_date("free_body", false);
}

#[test]
fn smooth_arm() {
    up_to_date("smooth_arm", true);
}

/// Where a command of the page leaves its results.
fn name_of(command: &str) -> &str {
    command.rsplit_once("--out ").unwrap().1
}

/// Compares tables made anew with those of the page. In flexible models small differences grow over the long run,
/// which is not made again.
fn up_to_date(name: &str, flexible: bool) {
    let command = commands().into_iter().find(|c| name_of(c) == name);
    // Times are not compared.
    let command = command.unwrap().replace(" --timed", "");
    let (command, more) = match flexible {
        true => (command.replace(" --long 10", ""), &[][..]),
        false => (command, &MORE[..]),
    };
    let found = made_anew(&command, name);
    let printed = results(name);
    for heading in TABLES.iter().chain(more) {
        let [a, b] = [&found, &printed].map(|text| table(text, heading));
        assert_eq!(a.len(), b.len(), "{heading}");
        compare_tables(name, heading, [&a, &b]);
    }
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
/// difference of nearly equal ones (trends, balances) or what iterations leave.
fn agree(heading: &str, column: &str, [found, printed]: [f64; 2]) -> bool {
    let long = heading == "What a long run keeps";
    let rest =
        (long || column.contains("balance") || column.contains("trend")) && printed.abs() < 1e-3;
    match rest {
        true => found.abs() < 10.0 * printed.abs() && printed.abs() < 10.0 * found.abs(),
        false => (found - printed).abs() <= 0.05 * printed.abs(),
    }
}

/// Compares a table with the one on the page; rows are found by their first cells.
fn compare_tables(name: &str, heading: &str, [found, printed]: [&[&str]; 2]) {
    let (head, keys) = (cells(printed[0]), keys(heading));
    for line in &found[2..] {
        let found = cells(line);
        let what = format!("{name}, {heading}: {line}");
        let same = |line: &&&str| cells(line)[..keys] == found[..keys];
        let printed = printed.iter().find(same);
        let printed = cells(printed.unwrap_or_else(|| panic!("{what}")));
        for (k, column) in head.iter().enumerate().skip(keys) {
            if column.ends_with("/ s") {
                continue;
            }
            let [a, b] = [&found[k], &printed[k]].map(|cell| numbers(heading, cell));
            assert_eq!(a.len(), b.len(), "{what}: {column}");
            for (a, b) in a.into_iter().zip(b) {
                let agree = agree(heading, column, [a, b]);
                assert!(agree, "{what}: {column}: {a} and not {b}");
            }
        }
    }
}
