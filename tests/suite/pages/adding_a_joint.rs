//! docs/adding_a_joint.md includes the example, all of it; .ci/run runs the example's model file.
#![allow(clippy::unwrap_used)]

const PAGE: &str = "docs/adding_a_joint.md";

#[test]
fn its_code_is_the_example() {
    let example = "examples/helical_joint.rs";
    crate::support::included::hold(PAGE, "```rust\n", 0..7, example, true);
}

#[test]
fn its_cam_is_the_example() {
    crate::support::included::hold(PAGE, "```rust\n", 7..11, "examples/cam.rs", false);
}

#[test]
fn its_model_file_is_the_example() {
    let file = "examples/helical_joint.toml";
    crate::support::included::hold(PAGE, "```toml\n", 0..1, file, true);
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
        (
            include_str!("../../../examples/helical_joint.rs"),
            "\nstruct",
        ),
        (
            include_str!("../../../examples/pin_in_a_slot.rs"),
            "\nstruct",
        ),
        (
            include_str!("../../../examples/point_on_a_space_curve.rs"),
            "\nstruct",
        ),
    ] {
        // What says where a slot ends is besides.
        let end = if example.contains("fn domain") {
            "    fn domain"
        } else {
            "\nconst"
        };
        let found = lines(example, from, end);
        assert!(found <= 15, "{found}");
    }
}
