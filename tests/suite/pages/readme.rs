//! What the README shows is what the repository has.

use super::included::lines_of_code;
use crate::support::included::blocks;
use crate::support::program::{read, repository};

const README: &str = include_str!("../../../README.md");

#[test]
fn the_first_program_is_the_example() {
    let example = include_str!("../../../examples/first_program.rs");
    assert_eq!(blocks(README, "```rust\n")[0].trim(), example.trim());
    assert!(lines_of_code(example) <= 30, "a first program is short");
}

#[test]
fn its_model_assembles() {
    let models = blocks(README, "```toml\n");
    assert_eq!(models.len(), 1);
    pullback::input::assemble_text("README.md", models[0]).unwrap();
}

#[test]
fn every_link_of_it_and_of_the_tutorial_leads_somewhere() {
    let tutorial = std::fs::read_dir(repository("docs/tutorial")).unwrap();
    let mut pages: Vec<_> = tutorial.map(|entry| entry.unwrap().path()).collect();
    pages.push(repository("README.md"));
    assert_eq!(pages.len(), 6);
    for page in pages {
        for part in read(&page).split("](").skip(1) {
            let link = part.split([')', '#']).next().unwrap();
            assert!(page.with_file_name(link).exists(), "{page:?}: {link}");
        }
    }
}
