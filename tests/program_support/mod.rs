//! A small model and directories for the tests of the program.
#![allow(dead_code, clippy::unwrap_used)]

use std::path::PathBuf;

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
pub fn files(path: &std::path::Path) -> Vec<String> {
    let entries = std::fs::read_dir(path).unwrap();
    let mut names: Vec<String> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}
