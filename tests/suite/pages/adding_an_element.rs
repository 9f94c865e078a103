//! docs/adding_an_element.md includes the example, all of it, and an element of the library.

const PAGE: &str = "docs/adding_an_element.md";

#[test]
fn its_code_is_the_example() {
    let example = "examples/nonlinear_spring.rs";
    crate::support::included::hold(PAGE, "```rust\n", 0..5, example, true);
    let bushing = "examples/elements/elastic_joint.rs";
    crate::support::included::hold(PAGE, "```rust\n", 5..6, bushing, false);
}

#[test]
fn its_element_has_fifteen_lines_at_most() {
    let page = include_str!("../../../docs/adding_an_element.md");
    let element = page.split("```rust\n").nth(2).unwrap();
    let lines = element.split("\n```").next().unwrap().lines();
    let code = lines.filter(|l| !l.trim().is_empty() && !l.trim().starts_with("//"));
    assert!(code.count() <= 15);
}
