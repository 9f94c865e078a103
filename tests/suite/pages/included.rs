//! Pages that include code and models: blocks, their source, and whether all of it is on the page.

use crate::support::included::hold;

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
    ] {
        let fence = if source.ends_with(".rs") {
            "```rust\n"
        } else {
            "```toml\n"
        };
        hold(&format!("docs/{page}.md"), fence, blocks, source, whole);
    }
}
