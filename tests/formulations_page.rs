//! The page of docs/formulations.md on smaller models: what theory says of orders and of energies. And
//! whether the page is up to date: its tables are what its commands print. That says nothing of whether
//! they are right, which the other tests are about.
#![allow(clippy::unwrap_used)]

mod program_support;

use program_support::{directory, files, read};
use pullback::compare::{Comparison, Options, Quantity, Subject, Watch, run_several};
use pullback::input;

const METHODS: [&str; 4] = ["newmark", "ul-newmark", "lie-newmark", "spin-newmark"];

const TOP: &str = include_str!("../examples/models/top.toml");
const ELBOW: &str = include_str!("../examples/models/elbow.toml");
const ARM: &str = include_str!("../docs/formulations/smooth_arm.toml");

fn subject(name: &str, text: &str, changes: &[(&str, &str)], steps: &[f64]) -> Subject<'static> {
    let mut text = text.to_owned();
    for (old, new) in changes {
        assert!(text.contains(old), "{name}: {old}");
        text = text.replace(old, new);
    }
    let file = input::parse(name, &text).unwrap();
    let model = name.to_owned();
    Subject {
        name: name.to_owned(),
        model: name.to_owned(),
        make: Box::new(move |formulation| input::job_in(&model, &file, formulation)),
        options: Options {
            long: Some(20.0),
            residual: Some(1e-10),
            ..Options::new(METHODS.map(|m| m.parse().unwrap()).to_vec(), steps.to_vec())
        },
    }
}

/// How much of the change of energy over the long run is a trend.
fn trend(comparison: &Comparison, method: &str) -> f64 {
    let row = comparison.long.iter().find(|row| row.scheme == method);
    let drift = row.unwrap().drift;
    (drift.trend.unwrap() / drift.energy.unwrap()).abs()
}

#[test]
fn all_keep_their_order_and_sums_of_spins_keep_the_energy_of_the_top() {
    let subjects = [
        subject(
            "top",
            TOP,
            &[("to = 1.5", "to = 0.5")],
            &[1e-3, 5e-4, 2.5e-4],
        ),
        subject(
            "elbow",
            ELBOW,
            &[("elements = 10", "elements = 2"), ("to = 30", "to = 6")],
            &[0.1, 0.05, 0.025],
        ),
        subject(
            "arm",
            ARM,
            &[("to = 3", "to = 0.6")],
            &[5e-3, 2.5e-3, 1.25e-3],
        ),
    ];
    let out = directory("formulations_page");
    let all = run_several(&subjects, None, &out, &Watch::NOBODY).unwrap();
    let mut found = files(&out);
    found.retain(|name| name.ends_with(".html"));
    assert_eq!(found, ["compare.html"]);
    let page = read(out.join("compare.html"));
    for name in [
        "Fast symmetrical top",
        "Right-angle cantilever",
        "Soft robot arm",
    ] {
        assert!(page.contains(name), "{name}");
    }
    for comparison in &all {
        let model = &comparison.model;
        for scheme in &comparison.orders {
            let order = scheme.of(Quantity::Rotation);
            // No sum of these loses the order of Newmark's scheme: the local errors are of third order.
            assert!(
                scheme.is_asymptotic(Quantity::Rotation),
                "{model}, {}: {order:?}",
                scheme.scheme
            );
        }
        let equal = comparison.equal_cost.as_ref().unwrap();
        assert_eq!(equal.schemes.len(), METHODS.len(), "{model}");
    }
    // Steps of sums of spins can be run backwards: energy comes and goes. Those of a chart that is
    // centred anew, or changed, cannot.
    let top = &all[0];
    for method in ["lie-newmark", "spin-newmark"] {
        assert!(trend(top, method) < 0.1, "{method}: {}", trend(top, method));
    }
    for method in ["newmark", "ul-newmark"] {
        assert!(trend(top, method) > 0.3, "{method}: {}", trend(top, method));
    }
    // On the top local errors are (h³/12)(Ω̈ + c Ω×Ω̇) with c = ½ for the updated Lagrangian, −1 and 2
    // for sums of spins (tests/spin_vectors.rs).
    let error = |method: &str| {
        let row = top.of(method).last().unwrap();
        row.error.unwrap().of(Quantity::Rotation)
    };
    for method in ["lie-newmark", "spin-newmark"] {
        assert!(error(method) > 2.0 * error("ul-newmark"), "{method}");
    }
}

const PAGE: &str = include_str!("../docs/formulations.md");

/// Where the results lie that the page shows.
fn results(name: &str) -> String {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    read(root.join("docs/formulations").join(name).join("compare.md"))
}

/// The first table under a heading, its lines.
fn table<'a>(text: &'a str, heading: &str) -> Vec<&'a str> {
    let found = text.split_once(&format!("\n## {heading}\n"));
    let (_, text) = found.unwrap_or_else(|| panic!("no heading {heading}"));
    let lines = text.lines().skip_while(|line| !line.starts_with('|'));
    lines.take_while(|line| line.starts_with('|')).collect()
}

/// The page with its tables copied from the results.
fn with_tables(page: &str) -> String {
    let mut out = String::new();
    let mut copied = false;
    for line in page.lines() {
        if line == "<!-- end -->" {
            copied = false;
        }
        if !copied {
            out += &format!("{line}\n");
        }
        let mark = line
            .strip_prefix("<!-- ")
            .and_then(|l| l.strip_suffix(" -->"));
        if let Some((name, heading)) = mark.and_then(|mark| mark.split_once(": ")) {
            for line in table(&results(name), heading) {
                out += &format!("{line}\n");
            }
            copied = true;
        }
    }
    out
}

/// The commands that the page shows.
fn commands() -> Vec<&'static str> {
    let lines = PAGE
        .lines()
        .filter(|line| line.starts_with("pullback compare "));
    lines.collect()
}

#[test]
fn the_tables_of_the_page_are_those_of_the_commands_on_it() {
    assert!(
        with_tables(PAGE) == PAGE,
        "run the ignored test that copies the tables"
    );
    assert!(PAGE.matches("\n<!-- end -->\n").count() >= 10);
    for command in commands() {
        let (_, name) = command.rsplit_once("--out ").unwrap();
        assert!(
            results(name).contains(&format!("```sh\n{command}\n```")),
            "{command}"
        );
    }
}

#[test]
#[ignore = "writes docs/formulations.md"]
fn copy_the_tables_to_the_page() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    std::fs::write(root.join("docs/formulations.md"), with_tables(PAGE)).unwrap();
}

/// Numbers of a cell: powers of ten are in raised digits.
fn numbers(cell: &str) -> Vec<f64> {
    let text = cell
        .replace("·10<sup>", "e")
        .replace("</sup>", "")
        .replace('−', "-");
    let parts = text.split(|c: char| !(c.is_ascii_alphanumeric() || "+-.".contains(c)));
    parts.filter_map(|part| part.parse().ok()).collect()
}

fn cells(line: &str) -> Vec<String> {
    let line = line.replace("\\|", "¦");
    line.trim_matches('|')
        .split('|')
        .map(|cell| cell.trim().to_owned())
        .collect()
}

/// How far a number may be from that on the page: five in a hundred, or ten times the number where it is a
/// difference of nearly equal ones (trends, confidence) or what iterations leave.
fn agree(heading: &str, column: &str, [found, printed]: [f64; 2]) -> bool {
    let rest = heading == "What a long run keeps" || column.contains("balance");
    match rest && printed.abs() < 1e-3 {
        true => found.abs() < 10.0 * printed.abs() && printed.abs() < 10.0 * found.abs(),
        false => (found - printed).abs() <= 0.05 * printed.abs(),
    }
}

/// Compares a table with the one on the page; rows are found by their first cells.
fn compare_tables(heading: &str, [found, printed]: [&[&str]; 2], keys: usize) {
    let head = cells(printed[0]);
    for line in &found[2..] {
        let found = cells(line);
        let same = |line: &&&str| cells(line)[..keys] == found[..keys];
        let printed = printed.iter().find(same);
        let printed = cells(printed.unwrap_or_else(|| panic!("{heading}: {line}")));
        for (k, column) in head.iter().enumerate().skip(keys) {
            if column.ends_with("/ s") {
                continue;
            }
            let [a, b] = [&found[k], &printed[k]].map(|cell| {
                // Of an order the slope; its confidence is scatter.
                let slope = cell.split(" ±").next().unwrap_or(cell);
                numbers(if heading.starts_with("Orders") {
                    slope
                } else {
                    cell
                })
            });
            assert_eq!(a.len(), b.len(), "{heading}, {column}: {line}");
            for (a, b) in a.into_iter().zip(b) {
                let what = format!("{heading}, {column}: {line}: {a} and not {b}");
                assert!(agree(heading, column, [a, b]), "{what}");
            }
        }
    }
}

/// Makes what a command of the page makes, in a directory of a test, with other arguments behind it.
fn made_anew(command: &str, directory: &str) -> String {
    let out = program_support::directory(directory);
    let arguments = command.split(' ').skip(1);
    let ran = std::process::Command::new(env!("CARGO_BIN_EXE_pullback"))
        .current_dir(&out)
        .args(arguments)
        .output()
        .unwrap();
    assert!(
        ran.status.success(),
        "{}",
        String::from_utf8_lossy(&ran.stderr)
    );
    let (_, name) = command.rsplit_once("--out ").unwrap();
    read(out.join(name).join("compare.md"))
}

/// The command of a rigid body.
fn command_of(name: &str) -> &'static str {
    let end = format!("--out {name}");
    let found = commands().into_iter().find(|c| c.ends_with(&end));
    found.unwrap_or_else(|| panic!("no command of {name}"))
}

/// The errors of the two largest steps, from a run of them alone: their reference is four times
/// coarser, which is nothing beside these errors.
fn errors_are_those_on_the_page(name: &str, steps: [&str; 2]) {
    let command = command_of(name);
    let short = command
        .replace(
            &format!("--steps {} --long 10", steps[0]),
            &format!("--steps {}", steps[1]),
        )
        .replace(" --timed --charts", "");
    assert!(short.len() + 20 < command.len(), "{short}");
    let found = made_anew(&short, &format!("formulations_{name}"));
    let printed = results(name);
    let heading = "Errors";
    let tables = [&found, &printed].map(|text| table(text, heading));
    assert_eq!(tables[0].len(), 2 + 2 * 5);
    compare_tables(heading, [&tables[0], &tables[1]], 3);
}

#[test]
fn errors_of_the_top_are_those_on_the_page() {
    errors_are_those_on_the_page("top", ["4x,2x,1x,0.5x", "4x,2x"]);
}

#[test]
fn errors_of_the_free_body_are_those_on_the_page() {
    errors_are_those_on_the_page("free_body", ["2x,1x,0.5x,0.25x", "2x,1x"]);
}

#[test]
#[ignore = "minutes; .ci/run makes it"]
fn all_tables_of_the_top_are_those_on_the_page() {
    all_tables_are_those_on_the_page("top");
}

#[test]
#[ignore = "minutes; .ci/run makes it"]
fn all_tables_of_the_free_body_are_those_on_the_page() {
    all_tables_are_those_on_the_page("free_body");
}

fn all_tables_are_those_on_the_page(name: &str) {
    let found = made_anew(command_of(name), &format!("formulations_all_{name}"));
    let printed = results(name);
    for (heading, keys) in [
        ("Orders of convergence", 2),
        ("Errors", 3),
        ("Errors at equal work", 1),
        ("Cost", 2),
        ("What the motion keeps", 2),
        ("What a long run keeps", 2),
        ("What changes of chart cost", 2),
    ] {
        let [a, b] = [&found, &printed].map(|text| table(text, heading));
        assert_eq!(a.len(), b.len(), "{heading}");
        compare_tables(heading, [&a, &b], keys);
    }
}
