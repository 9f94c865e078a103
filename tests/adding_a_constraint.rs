//! What docs/adding_a_constraint.md shows is the example, all of it.
#![allow(clippy::unwrap_used)]

const PAGE: &str = include_str!("../docs/adding_a_constraint.md");

#[test]
fn its_code_is_the_example() {
    let example = include_str!("../examples/trammel.rs");
    let parts = PAGE.split("```rust\n").skip(1);
    let blocks: Vec<&str> = parts
        .map(|part| part.split("\n```").next().unwrap())
        .collect();
    assert_eq!(blocks.len(), 6);
    assert_eq!(blocks.join("\n\n"), example.trim());
}
