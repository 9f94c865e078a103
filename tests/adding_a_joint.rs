//! What docs/adding_a_joint.md shows is the example, all of it; .ci/run runs the example's model file.
#![allow(clippy::unwrap_used)]

const PAGE: &str = include_str!("../docs/adding_a_joint.md");

fn blocks(language: &str) -> Vec<&str> {
    let parts = PAGE.split(language).skip(1);
    parts
        .filter_map(|part| part.split("\n```").next())
        .collect()
}

#[test]
fn its_code_is_the_example() {
    let example = include_str!("../examples/helical_joint.rs");
    let blocks = blocks("```rust\n");
    assert_eq!(blocks.len(), 7);
    assert_eq!(blocks.join("\n\n"), example.trim());
}

#[test]
fn its_model_file_is_the_example() {
    let file = include_str!("../examples/helical_joint.toml");
    assert_eq!(blocks("```toml\n"), [file.trim()]);
}

/// Lines of code of a joint: from its struct to the end of its `impl`.
fn lines(example: &str, from: &str, to: &str) -> usize {
    let joint = example.split(from).nth(1).unwrap();
    let joint = joint.split(to).next().unwrap();
    let code = joint.lines().map(str::trim);
    code.filter(|l| !l.is_empty() && !l.starts_with("//") && !l.starts_with('#'))
        .count()
}

#[test]
fn a_joint_has_fifteen_lines_at_most() {
    for (example, from) in [
        (include_str!("../examples/helical_joint.rs"), "\nstruct"),
        (include_str!("../examples/pin_in_a_slot.rs"), "\nstruct"),
        (
            include_str!("../examples/point_on_a_space_curve.rs"),
            "\nstruct",
        ),
    ] {
        // What says where a slot ends is besides.
        let end = if example.contains("fn margin") {
            "    fn margin"
        } else {
            "\nconst"
        };
        let found = lines(example, from, end);
        assert!(found <= 15, "{found}");
    }
}
