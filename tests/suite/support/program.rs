//! A small model and directories for the tests of the program.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use nalgebra::DMatrix;
use pullback::input::{InputError, assemble_text};
use pullback::run::run;
use serde_json::Value;
use std::collections::HashMap;
use std::fmt::Display;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

/// A cantilever bent by an end moment M = (π/2) EI/L: a quarter of a circle.
pub const MODEL: &str = r#"title = "Quarter circle"
[sections.main]
stiffness = { EA = 1e6, GA = [1e6, 1e6], GJ = 2.0, EI = [2.0, 2.0] }
[nodes]
A = [0, 0, 0]
B = [1, 0, 0]
[[lines]]
name = "beam"
from = "A"
to = "B"
elements = 8
section = "main"
[[supports]]
node = "A"
fix = "all"
[[loads]]
node = "B"
moment = [0, 0, 3.141592653589793]
[analysis.static]
steps = 4
[[probes]]
name = "tip"
node = "B"
quantity = "displacement"
[[probes]]
name = "turn"
node = "B"
quantity = "rotation"
component = "z"
[[probes]]
name = "clamp"
node = "A"
quantity = "reaction_moment"
component = "z"
[[probes]]
name = "bending"
element = "beam:4"
quantity = "M"
component = "3"
"#;

/// The model with one part of its text replaced.
pub fn with(old: &str, new: &str) -> String {
    assert!(MODEL.contains(old), "the model does not contain {old:?}");
    MODEL.replacen(old, new, 1)
}

/// An empty directory of a name.
pub fn directory(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::remove_dir_all(&path).ok();
    std::fs::create_dir_all(&path).unwrap();
    path
}

/// Names of the files in a directory, sorted.
pub fn files(path: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(path).unwrap();
    let mut names: Vec<String> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// The refusal of a text.
pub fn refusal(text: &str) -> InputError {
    match assemble_text("model.toml", text) {
        Ok(_) => panic!("this was accepted:\n{text}"),
        Err(error) => error,
    }
}

/// Refuses `text` with a message, advice, and a position whose text begins with `position`.
#[track_caller]
pub fn check(text: &str, position: &str, message: &str, advice: &str) {
    check_error(text, &refusal(text), position, message, advice);
}

/// A text contains all of these.
#[track_caller]
pub fn assert_says(said: &str, words: &[&str]) {
    for word in words {
        assert!(said.contains(word), "{word:?} is not in\n{said}");
    }
}

/// A number is another one but for a small difference.
#[track_caller]
pub fn assert_close(found: f64, exact: f64, within: f64, what: impl Display) {
    let off = (found - exact).abs();
    assert!(off < within, "{what}: {found} {exact}");
}

/// Rows of a table with bars between their cells; missing cells are empty. A row that begins with # is a comment.
pub fn cells<const N: usize>(table: &str) -> impl Iterator<Item = [&str; N]> {
    let rows = table.lines().map(str::trim);
    let rows = rows.filter(|row| !row.is_empty() && !row.starts_with('#'));
    rows.map(|row| {
        let mut cells = row.split('|').map(str::trim);
        let all = std::array::from_fn(|_| cells.next().unwrap_or_default());
        assert_eq!(cells.next(), None, "{row}");
        all
    })
}

/// A text with other words: lines of `old => new`, in which `&` is the old text and `\n` ends a line.
pub fn changed(text: &str, changes: &str) -> String {
    changes.lines().fold(text.to_owned(), |text, line| {
        let [old, new] = line.split_once("=>").unwrap().into();
        let [old, new] = [old, new].map(|words| words.trim().replace("\\n", "\n"));
        assert!(text.contains(&old), "the model does not contain {old:?}");
        text.replacen(&old, &new.replace('&', &old), 1)
    })
}

/// Refuses each [change](changed) of a model in a table of `old => new | position | message | advice`. A row without
/// `old` changes what the row before does.
#[track_caller]
pub fn check_table(model: &str, refusal: impl Fn(&str) -> InputError, table: &str) {
    let mut old = "";
    for [change, position, message, advice] in cells(table) {
        println!("{change}");
        let [from, to] = change.split_once("=>").unwrap().into();
        if !from.is_empty() {
            old = from;
        }
        let text = changed(model, &format!("{old}=>{to}"));
        check_error(&text, &refusal(&text), position, message, advice);
    }
}

/// Refuses each line of a table of `arguments | words of the refusal | more of them`, after the words of a command.
#[track_caller]
pub fn check_lines(directory: &Path, command: &str, table: &str) {
    for [arguments, words, more] in cells(table) {
        println!("{arguments}");
        let said = ended(&program_in(directory, &format!("{command} {arguments}")), 2);
        assert_says(&said, &[words, more]);
    }
}

#[track_caller]
fn check_error(text: &str, error: &InputError, position: &str, message: &str, advice: &str) {
    let said = error.to_string();
    assert_says(&said, &[message]);
    assert_says(&error.problem.advice().unwrap_or_default(), &[advice]);
    let span = error.span.clone().expect("a position");
    assert!(
        text[span.clone()].starts_with(position),
        "{said}: position {:?} instead of {position:?}",
        &text[span.start..(span.end + 20).min(text.len())]
    );
    let before = &text[..span.start];
    let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
    let line = before.matches('\n').count() + 1;
    assert_eq!(error.line_column(), Some((line, column)));
}

/// The program, running a model with arguments.
pub fn program(arguments: &[&Path]) -> Output {
    command("run", arguments)
}

/// The program, doing one of its commands with arguments.
pub fn command(name: &str, arguments: &[&Path]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pullback"))
        .arg(name)
        .args(arguments)
        .output()
        .unwrap()
}

/// The program in a model's directory, comparing schemes on it with the words of a line.
pub fn compare(model: &Path, words: &str) -> Output {
    let name = model.file_name().unwrap().to_str().unwrap();
    program_in(model.parent().unwrap(), &format!("compare {name} {words}"))
}

/// The program in a directory, with the words of a line.
pub fn program_in(directory: &Path, line: &str) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_pullback"));
    let program = program.current_dir(directory).args(line.split_whitespace());
    program.output().unwrap()
}

/// A command of the program under way with a model; what it says can be read.
pub fn spawned(command: &[&str], model: &Path) -> Child {
    let mut program = Command::new(env!("CARGO_BIN_EXE_pullback"));
    let program = program.args(command).arg(model);
    let program = program.stdout(Stdio::piped()).stderr(Stdio::piped());
    program.spawn().unwrap()
}

/// What the program prints in a directory with the words of a line.
#[track_caller]
pub fn printed(directory: &Path, line: &str) -> String {
    let output = program_in(directory, line);
    succeeded(&output);
    String::from_utf8(output.stdout).unwrap()
}

/// What a run that succeeds tells on standard error.
#[track_caller]
pub fn succeeded(output: &Output) -> String {
    ended(output, 0)
}

/// What a run that ends with a code tells on standard error.
#[track_caller]
pub fn ended(output: &Output, code: i32) -> String {
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{said}");
    said
}

/// Runs a model of this text in a directory; where its results are.
#[track_caller]
pub fn ran(directory: &Path, text: &str) -> PathBuf {
    succeeded(&program(&[&write(directory, text)]));
    directory.join("model.out")
}

/// Rows of history.csv by column name.
pub type Rows = Vec<HashMap<String, String>>;

/// What a run leaves.
pub struct Ran {
    /// Where its results are.
    pub out: PathBuf,
    /// What it says on standard error.
    pub said: String,
    pub rows: Rows,
    /// What result.json says.
    pub result: Value,
}

/// The run of a text in a new directory of a name. What result.json warns of it says as well.
#[track_caller]
pub fn run_of(name: &str, text: &str) -> Ran {
    let directory = directory(name);
    let said = succeeded(&program(&[&write(&directory, text)]));
    let out = directory.join("model.out");
    let (rows, result) = (history(&out), results(&out));
    for warning in result["warnings"].as_array().unwrap() {
        assert_says(&said, &[warning.as_str().unwrap()]);
    }
    Ran {
        out,
        said,
        rows,
        result,
    }
}

/// What the run of a text in a new directory of a name says that fails.
#[track_caller]
pub fn failed(name: &str, text: &str) -> String {
    ended(&program(&[&write(&directory(name), text)]), 1)
}

/// Notes and warnings of a run in a new directory of a name.
pub fn told(name: &str, text: &str) -> [Vec<String>; 2] {
    let out = directory(name);
    let ran = run(&write(&out, text), None, &mut |_| ControlFlow::Continue(()));
    let ran = ran.unwrap();
    [ran.notes, ran.warnings]
}

/// The rows that a model of this text leaves when it runs in a new directory of a name.
#[track_caller]
pub fn recorded(name: &str, text: &str) -> Rows {
    history(&ran(&directory(name), text))
}

/// A model file of this text in a directory.
pub fn write(directory: &Path, text: &str) -> PathBuf {
    let path = directory.join("model.toml");
    std::fs::write(&path, text).unwrap();
    path
}

/// The text of a file.
pub fn read(path: impl AsRef<Path>) -> String {
    std::fs::read_to_string(path).unwrap()
}

/// A file or directory of the repository.
pub fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The text of a model of the examples.
pub fn example(name: &str) -> String {
    let models = repository("examples/models");
    read(models.join(name).with_extension("toml"))
}

/// What a file in JSON says.
pub fn json(path: impl AsRef<Path>) -> Value {
    serde_json::from_str(&read(path)).unwrap()
}

/// What result.json says.
pub fn results(out: &Path) -> Value {
    json(out.join("result.json"))
}

/// The numbers of a table after its head.
pub fn csv(path: impl AsRef<Path>) -> Vec<Vec<f64>> {
    let text = read(path);
    let rows = text.lines().skip(1);
    rows.map(|row| row.split(',').map(|x| x.parse().unwrap()).collect())
        .collect()
}

/// Rows that a run leaves where its results are.
pub fn history(out: &Path) -> Rows {
    let table = csv::Reader::from_path(out.join("history.csv"));
    let rows = table.unwrap().into_deserialize();
    rows.map(Result::unwrap).collect()
}

/// A cell as a number.
pub fn number(row: &HashMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap()
}

/// The matrix of a file in Matrix Market format.
pub fn matrix(path: &Path) -> DMatrix<f64> {
    let text = read(path);
    let mut lines = text.lines();
    let kind = "%%MatrixMarket matrix coordinate real general";
    assert_eq!(lines.next(), Some(kind));
    let mut rows = lines.map(|line| -> Vec<f64> {
        let numbers = line.split(' ');
        numbers.map(|x| x.parse().unwrap()).collect()
    });
    let size = rows.next().unwrap();
    let mut out = DMatrix::zeros(size[0] as usize, size[1] as usize);
    let entries: Vec<_> = rows.collect();
    assert_eq!(entries.len(), size[2] as usize);
    for entry in entries {
        out[(entry[0] as usize - 1, entry[1] as usize - 1)] = entry[2];
    }
    out
}

/// Numbers of an array of a grid.
pub fn grid_array(document: &roxmltree::Document<'_>, name: &str) -> Vec<f64> {
    let mut all = document.descendants();
    let found = all.find(|n| n.attribute("Name") == Some(name));
    let found = found.unwrap_or_else(|| panic!("no array {name}"));
    let bytes = BASE64_STANDARD.decode(found.text().unwrap()).unwrap();
    let (number, data) = bytes.split_first_chunk::<8>().unwrap();
    assert_eq!(u64::from_le_bytes(*number), data.len() as u64);
    match found.attribute("type").unwrap() {
        "Float64" => numbers(data, f64::from_le_bytes),
        "Int64" => numbers(data, |x| i64::from_le_bytes(x) as f64),
        "Int32" => numbers(data, |x| i32::from_le_bytes(x).into()),
        "UInt8" => numbers(data, |[x]| x.into()),
        other => panic!("numbers of type {other}"),
    }
}

/// The numbers of N bytes each.
fn numbers<const N: usize>(data: &[u8], number: impl Fn([u8; N]) -> f64) -> Vec<f64> {
    data.as_chunks().0.iter().map(|x| number(*x)).collect()
}
