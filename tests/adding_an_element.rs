//! What docs/adding_an_element.md shows is the example, all of it, and an element of the library.

const PAGE: &str = include_str!("../docs/adding_an_element.md");

#[test]
fn its_code_is_the_example() {
    let example = include_str!("../examples/nonlinear_spring.rs");
    let blocks: Vec<&str> = PAGE
        .split("```rust\n")
        .skip(1)
        .map(|part| part.split("\n```").next().unwrap())
        .collect();
    assert_eq!(blocks.len(), 6);
    assert_eq!(blocks[..5].join("\n\n"), example.trim());
    let bushing = include_str!("../elements/src/energy/bushing.rs");
    assert!(bushing.trim().ends_with(blocks[5]));
    assert!(blocks[5].starts_with("impl ElasticJoint"));
}

#[test]
fn its_element_has_fifteen_lines_at_most() {
    let element = PAGE.split("```rust\n").nth(2).unwrap();
    let lines = element.split("\n```").next().unwrap().lines();
    let code = lines.filter(|l| !l.trim().is_empty() && !l.trim().starts_with("//"));
    assert!(code.count() <= 15);
}
