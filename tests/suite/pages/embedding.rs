//! docs/embedding.md includes the example, all of it.

#[test]
fn its_code_is_the_example() {
    let example = "examples/controlled_joint.rs";
    crate::support::included::hold("docs/embedding.md", "```rust\n", 0..5, example, true);
}
