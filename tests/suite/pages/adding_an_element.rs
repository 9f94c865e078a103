//! The element of docs/adding_an_element.md.

#[test]
fn its_element_has_fifteen_lines_at_most() {
    let page = include_str!("../../../docs/adding_an_element.md");
    let element = page.split("```rust\n").nth(2).unwrap();
    let lines = element.split("\n```").next().unwrap().lines();
    let code = lines.filter(|l| !l.trim().is_empty() && !l.trim().starts_with("//"));
    assert!(code.count() <= 15);
}
