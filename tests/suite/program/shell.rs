//! What the program prints for shells and for `man`.
#![allow(clippy::unwrap_used)]

use crate::support::program::{command, succeeded};
use std::path::Path;

fn printed(name: &str, arguments: &[&str]) -> String {
    let words: Vec<&Path> = arguments.iter().map(Path::new).collect();
    let output = command(name, &words);
    succeeded(&output);
    String::from_utf8(output.stdout).unwrap()
}

/// The commands that `pullback help` lists.
fn commands() -> Vec<String> {
    let help = printed("help", &[]);
    let list = help.split_once("Commands:\n").unwrap().1;
    let lines = list.lines().take_while(|line| !line.is_empty());
    let indented = lines.filter_map(|line| line.strip_prefix("  "));
    let names = indented.filter(|line| !line.starts_with(' '));
    let names = names.map(|line| line.split(' ').next().unwrap().to_owned());
    let names: Vec<String> = names.filter(|name| name != "help").collect();
    assert!(names.contains(&"run".to_owned()), "{help}");
    names
}

#[test]
fn the_manual_has_a_page_of_every_command() {
    let manual = printed("man", &[]);
    assert!(manual.contains("\n.TH pullback 1"));
    for name in commands() {
        assert!(
            manual.contains(&format!("\n.TH pullback-{name} 1")),
            "{name}"
        );
    }
    // Options of the commands are described.
    assert!(manual.contains("Resumes from the checkpoint"), "{manual}");
}

#[test]
fn bash_completes_every_command() {
    let script = printed("completions", &["bash"]);
    for name in commands() {
        assert!(script.contains(&format!("pullback,{name})")), "{name}");
    }
}
