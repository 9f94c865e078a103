//! What the README shows is what the repository has.

use super::included::lines_of_code;
use crate::support::program::read;
use std::path::Path;

const README: &str = include_str!("../../../README.md");

/// The fenced block that starts with the given line.
fn block(fence: &str) -> &'static str {
    let start = README.find(fence).unwrap() + fence.len() + 1;
    let end = README[start..].find("\n```").unwrap();
    &README[start..start + end]
}

#[test]
fn the_first_program_is_the_example() {
    let example = include_str!("../../../examples/first_program.rs");
    assert_eq!(block("```rust").trim(), example.trim());
    assert!(lines_of_code(example) <= 30, "a first program is short");
}

#[test]
fn its_model_assembles() {
    assert_eq!(README.matches("```toml\n").count(), 1);
    pullback::input::assemble_text("README.md", block("```toml")).unwrap();
}

#[test]
fn every_link_of_it_and_of_the_tutorial_leads_somewhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let tutorial = std::fs::read_dir(root.join("docs/tutorial")).unwrap();
    let mut pages: Vec<_> = tutorial.map(|entry| entry.unwrap().path()).collect();
    pages.push(root.join("README.md"));
    assert_eq!(pages.len(), 6);
    for page in pages {
        for part in read(&page).split("](").skip(1) {
            let link = part.split([')', '#']).next().unwrap();
            assert!(page.with_file_name(link).exists(), "{page:?}: {link}");
        }
    }
}
