//! Joints of the examples that docs/adding_a_joint.md includes.
#![allow(clippy::unwrap_used)]

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
    for example in [
        include_str!("../../../examples/helical_joint.rs"),
        include_str!("../../../examples/pin_in_a_slot.rs"),
        include_str!("../../../examples/point_on_a_space_curve.rs"),
    ] {
        // What says where a slot ends is besides.
        let end = if example.contains("fn domain") {
            "    fn domain"
        } else {
            "\nconst"
        };
        let found = lines(example, "\nstruct", end);
        assert!(found <= 15, "{found}");
    }
}
