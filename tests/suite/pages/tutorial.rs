//! The tutorial shows models and code of the examples, and what the program prints and draws.

use crate::support::formulations::{cells, plain};
use crate::support::included::{blocks, hold, hold_pieces, update};
use crate::support::program::*;
use std::fs::create_dir_all;
use std::path::{Path, PathBuf};

const TOML: &str = "```toml\n";

/// An empty directory with a model of the examples, whose parts are replaced.
fn with_model(directory: &Path, model: &str, changes: &str) -> PathBuf {
    let path = directory.join("examples/models").join(model);
    create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(&path, changed(&example(model), changes)).unwrap();
    path
}

/// Runs a model of the examples, whose parts are replaced, in a directory; where its results are.
fn ran(directory: &Path, model: &str, changes: &str) -> PathBuf {
    let path = with_model(directory, model, changes);
    printed(directory, &format!("run examples/models/{model}"));
    path.with_extension("out")
}

/// Whether two texts are the same but for numbers that differ by the tolerance at most, as rounding
/// errors do from machine to machine.
fn alike(a: &str, b: &str, tolerance: f64) -> bool {
    let words = |text: &'_ str| -> Vec<String> {
        let ends = |c: char| c.is_whitespace() || c == ',' || c == '"';
        text.split(ends).map(str::to_owned).collect()
    };
    let (a, b) = (words(a), words(b));
    let near = |a: &str, b: &str| match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => (a - b).abs() <= tolerance,
        _ => a == b,
    };
    a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| near(a, b))
}

/// Runs the commands of a page that are followed by their output, and holds the page to it.
fn hold_output(page: &str, directory: &Path) {
    const COMMAND: &str = "```sh\npullback ";
    let before = read(repository(page));
    let mut parts = before.split(COMMAND);
    let mut after = parts.next().unwrap().to_owned();
    let mut commands = 0;
    for part in parts {
        let (command, rest) = part.split_once("\n```\n").unwrap();
        after += &[COMMAND, command, "\n```\n"].concat();
        let Some(old) = rest.strip_prefix("\n```text\n") else {
            after += rest;
            continue;
        };
        let output = printed(directory, &command.replace('\\', ""));
        let (old, rest) = old.split_once("```\n").unwrap();
        let same = alike(old.trim_end(), output.trim_end(), 1e-12);
        let text = if same { old } else { &output };
        after += &["\n```text\n", text.trim_end(), "\n```\n", rest].concat();
        commands += 1;
    }
    assert!(commands > 0, "{page} has no command with its output");
    update(page, &before, &after);
}

/// Holds a picture of the tutorial to what the program has drawn.
fn hold_picture(name: &str, drawn: &Path) {
    let path = format!("docs/images/tutorial/{name}.svg");
    let before = std::fs::read_to_string(repository(&path)).unwrap_or_default();
    let after = read(drawn);
    // Positions are whole numbers, 8 to a point.
    if !alike(&before, &after, 1.0) {
        update(&path, &before, &after);
    }
}

/// Cells of the rows of all tables of a page whose first cell is given.
fn rows(page: &str, first: &str) -> Vec<Vec<String>> {
    let page = read(repository(page));
    let page = plain(&page.replace('`', ""));
    let lines = page.lines().filter(|line| line.starts_with('|'));
    let cells = lines.map(cells);
    cells.filter(|cells| cells[0] == first).collect()
}

/// Whether a cell is the number as it is written there, in its last digit or in a tenth of the value.
#[track_caller]
fn is(cell: &str, value: f64) {
    let shown: f64 = cell.parse().unwrap();
    let digits = cell.split('.').nth(1).map_or(0, str::len);
    let unit = match cell.contains('e') {
        true => 0.1 * shown.abs(),
        false => 0.51 * 0.1_f64.powi(i32::try_from(digits).unwrap()),
    };
    // What is left of rounding errors is different on every machine.
    let off = (shown - value).abs();
    let rest = shown.max(value.abs()) < 1e-12;
    assert!(off <= unit || rest, "{cell} for {value}");
}

#[test]
fn the_beam() {
    const PAGE: &str = "docs/tutorial/1_beam.md";
    hold(PAGE, TOML, 0..1, "examples/models/elastica.toml", true);
    let place = directory("tutorial_beam");
    let model = with_model(&place, "elastica.toml", "");
    hold_output(PAGE, &place);
    let out = model.with_extension("out");
    hold_picture("elastica", &out.join("deformed.svg"));
    let steps = history(&out);
    for (load, t) in [("1", 0.1), ("5", 0.5), ("10", 1.0)] {
        let step = steps.iter().find(|row| number(row, "t") == t).unwrap();
        let row = &rows(PAGE, load)[0];
        is(&row[1], number(step, "tip.y"));
        is(&row[3], -number(step, "tip.x"));
    }
    for [elements, order] in [["5", "1"], ["10", "1"], ["20", "1"], ["5", "2"], ["5", "3"]] {
        let changes =
            format!("elements = 20 => elements = {elements}\norder = 3 => order = {order}");
        let steps = history(&ran(&place, "elastica.toml", &changes));
        let tip = number(steps.last().unwrap(), "tip.y");
        let mut found = rows(PAGE, elements).into_iter();
        let row = found.find(|r| r.len() == 4 && r[1] == order).unwrap();
        is(&row[2], tip);
        // Exact: elliptic integrals (Mattiasson 1981).
        is(&row[3], 0.8106090249 - tip);
    }
    let last = history(&ran(&place, "rollup.toml", "")).pop().unwrap();
    assert!(read(repository(PAGE)).contains(" 12.5663706144,"));
    is("12.5663706144", number(&last, "turn"));
    assert!((number(&last, "tip.x") + 1.0).abs() < 1e-12);
}

#[test]
fn the_mechanism() {
    const PAGE: &str = "docs/tutorial/2_mechanism.md";
    hold_pieces(PAGE, TOML, 0..3, "examples/models/four_bar.toml");
    let place = directory("tutorial_mechanism");
    let model = with_model(&place, "four_bar.toml", "");
    hold_output(PAGE, &place);
    let out = model.with_extension("out");
    hold_picture("four_bar", &out.join("deformed.svg"));
    for (first, step) in [
        ("step 0.002", "step = 0.002"),
        ("step 0.001, as in the file", "step = 0.001"),
        ("step 0.0005", "step = 0.0005"),
    ] {
        let changes = format!("step = 0.001 => {step}");
        let steps = history(&ran(&place, "four_bar.toml", &changes));
        let gap = |axis| {
            let [a, b] = ["a", "b"].map(|end| format!("gap {end}.{axis}"));
            steps
                .iter()
                .map(move |row| (number(row, &a) - number(row, &b)).abs())
        };
        assert!(gap("x").chain(gap("y")).all(|gap| gap < 1e-14));
        let last = steps.last().unwrap();
        let [x, y] = ["gap a.x", "gap a.y"].map(|name| number(last, name));
        let row = &rows(PAGE, first)[0];
        is(&row[1], x);
        is(&row[2], y);
        // Exact: as in the gallery.
        is(&row[3], (x - 1.5714799768).hypot(y - 1.9414393136));
    }
}

#[test]
fn the_motion() {
    const PAGE: &str = "docs/tutorial/3_motion.md";
    hold_pieces(PAGE, TOML, 0..1, "examples/models/pendulum.toml");
    hold_pieces(PAGE, TOML, 1..2, "examples/models/double_pendulum.toml");
    let place = directory("tutorial_motion");
    with_model(&place, "pendulum.toml", "");
    hold_output(PAGE, &place);
    for step in ["0.02", "0.01", "0.005"] {
        let changes = format!("step = 0.01 => step = {step}");
        let steps = history(&ran(&place, "pendulum.toml", &changes));
        let last = steps.last().unwrap();
        let [x, z] = ["bob.x", "bob.z"].map(|name| number(last, name));
        let row = &rows(PAGE, step)[0];
        is(&row[1], x);
        is(&row[2], z);
        // Exact: elliptic functions, as in the gallery.
        let off = (x + 0.275087462576117).hypot(z + 0.961419205099125);
        is(&row[3], off);
        let defects = steps.iter().map(|row| number(row, "energy_defect").abs());
        is(&row[4], defects.fold(0.0, f64::max));
    }
    let page = read(repository(PAGE));
    let (_, schemes) = page.split_once("| `scheme` |").unwrap();
    let schemes = schemes.lines().skip(2);
    let schemes: Vec<&str> = schemes.take_while(|l| l.starts_with('|')).collect();
    assert_eq!(schemes.len(), 6);
    for row in schemes {
        let cells = cells(row);
        let scheme = cells[0].trim_matches('`');
        let changes = format!(
            "{{ newmark = [0.25, 0.5] }} => {scheme}\nrecord_every = 5 => record_every = 1"
        );
        let steps = history(&ran(&place, "double_pendulum.toml", &changes));
        let defects = steps.iter().map(|row| number(row, "energy_defect").abs());
        is(&cells[2], defects.fold(0.0, f64::max));
        let solutions: f64 = steps.iter().map(|row| number(row, "iterations")).sum();
        is(&cells[3], solutions / (steps.len() - 1) as f64);
    }
    let out = ran(&place, "double_pendulum.toml", "");
    hold_picture("double_pendulum", &out.join("deformed.svg"));
    hold_picture("double_pendulum_history", &out.join("history.svg"));
}

#[test]
fn the_joint() {
    const PAGE: &str = "docs/tutorial/4_joint.md";
    hold_pieces(PAGE, "```rust\n", 0..4, "examples/helical_joint.rs");
    hold_pieces(PAGE, TOML, 0..1, "examples/helical_joint.toml");
}

#[test]
fn the_comparison() {
    const PAGE: &str = "docs/tutorial/5_comparison.md";
    let place = directory("tutorial_comparison");
    hold_output(PAGE, &place);
    hold_picture("spectrum", &place.join("spectrum/spectrum.svg"));
    let text = read(repository(PAGE));
    let command = blocks(&text, "```sh\npullback compare ")[0];
    let table = printed(&place, &format!("compare {}", command.replace('\\', "")));
    hold_picture("convergence", &place.join("comparison/convergence.svg"));
    let report = plain(&read(place.join("comparison/compare.md")));
    let (_, work) = report.split_once("## Errors at equal work").unwrap();
    assert_says(work, &["At 1415 assemblies"]);
    let errors = read(place.join("comparison/compare.csv"));
    let head: Vec<&str> = errors.lines().next().unwrap().split(',').collect();
    let column = |name| head.iter().position(|h| *h == name).unwrap();
    let [scheme_at, error_at] = ["scheme", "error_position"].map(column);
    for scheme in ["newmark", "ga:0.8", "bathe", "radau"] {
        let [orders, costs] = &rows(PAGE, scheme)[..] else {
            panic!("two tables have {scheme}");
        };
        let line = table.lines().find(|l| l.starts_with(scheme)).unwrap();
        assert_says(line, &[&orders[2]]);
        let lines = errors.lines().map(|l| l.split(',').collect::<Vec<_>>());
        let lines = lines.filter(|cells| cells[scheme_at] == scheme);
        let found: Vec<f64> = lines.map(|c| c[error_at].parse().unwrap()).collect();
        assert_eq!(found.len(), 4);
        for (cell, error) in orders[3..].iter().zip(found) {
            is(cell, error);
        }
        let row = format!("| {scheme} | {} ({})", costs[1], costs[2]);
        assert_says(work, &[&row]);
    }
}
