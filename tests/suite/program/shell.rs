//! What the program prints for shells and for `man`.

use crate::support::program::{assert_says, printed};
use std::path::Path;

/// The commands that `pullback help` lists.
fn commands() -> Vec<String> {
    let help = printed(Path::new("."), "help");
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
    let manual = printed(Path::new("."), "man");
    assert!(manual.contains("\n.TH pullback 1"));
    for name in commands() {
        assert_says(&manual, &[&format!("\n.TH pullback-{name} 1")]);
    }
    // Options of the commands are described.
    assert_says(&manual, &["Resumes from the checkpoint"]);
}

#[test]
fn bash_completes_every_command() {
    let script = printed(Path::new("."), "completions bash");
    for name in commands() {
        assert_says(&script, &[&format!("pullback,{name})")]);
    }
}
