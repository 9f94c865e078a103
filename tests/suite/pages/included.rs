//! Pages that include code and models: blocks, their source, and whether all of it is on the page.

use crate::support::included::{blocks, hold};

#[test]
fn code_and_models_are_those_of_the_sources() {
    for (page, blocks, source, whole) in [
        ("adding_a_constraint", 0..6, "examples/trammel.rs", true),
        ("adding_a_joint", 0..7, "examples/helical_joint.rs", true),
        ("adding_a_joint", 7..11, "examples/cam.rs", false),
        ("adding_a_joint", 0..1, "examples/helical_joint.toml", true),
        (
            "adding_an_element",
            0..5,
            "examples/nonlinear_spring.rs",
            true,
        ),
        (
            "adding_an_element",
            5..6,
            "examples/elements/drag.rs",
            false,
        ),
        (
            "adding_an_element",
            6..7,
            "examples/elements/elastic_joint.rs",
            false,
        ),
        (
            "adding_an_integrator",
            0..4,
            "integrators/src/dynamics/scheme/bathe.rs",
            true,
        ),
        ("embedding", 0..5, "examples/controlled_joint.rs", true),
        ("modes", 0..3, "examples/rotating_blade.rs", true),
        ("modes", 3..6, "examples/cart_pole.rs", true),
        ("modes", 6..10, "examples/critical_loads.rs", true),
    ] {
        let fence = if source.ends_with(".rs") {
            "```rust\n"
        } else {
            "```toml\n"
        };
        hold(&format!("docs/{page}.md"), fence, blocks, source, whole);
    }
}

/// Lines of code in a text.
pub(super) fn lines_of_code(text: &str) -> usize {
    let lines = text.lines().map(str::trim);
    let code = lines.filter(|l| !l.is_empty() && !["//", "#"].iter().any(|c| l.starts_with(c)));
    code.count()
}

#[test]
fn an_element_has_fifteen_lines_at_most() {
    let page = include_str!("../../../docs/adding_an_element.md");
    assert!(lines_of_code(blocks(page, "```rust\n")[1]) <= 15);
}

/// From its struct to the end of its `impl`, without what says where a slot ends.
#[test]
fn a_joint_has_fifteen_lines_at_most() {
    for (example, end) in [
        (
            include_str!("../../../examples/helical_joint.rs"),
            "\nconst",
        ),
        (
            include_str!("../../../examples/pin_in_a_slot.rs"),
            "    fn domain",
        ),
        (
            include_str!("../../../examples/point_on_a_space_curve.rs"),
            "\nconst",
        ),
    ] {
        let joint = example.split("\nstruct").nth(1).unwrap();
        let found = lines_of_code(joint.split(end).next().unwrap());
        assert!(found <= 15, "{found}");
    }
}
