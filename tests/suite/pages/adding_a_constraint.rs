//! docs/adding_a_constraint.md includes the example, all of it.

#[test]
fn its_code_is_the_example() {
    let [page, example] = ["docs/adding_a_constraint.md", "examples/trammel.rs"];
    crate::support::included::hold(page, "```rust\n", 0..6, example, true);
}
