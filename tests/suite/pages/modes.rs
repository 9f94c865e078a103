//! docs/modes.md includes the example, all of it, and a model with the numbers that it states.
#![allow(clippy::unwrap_used)]

use crate::support::included::hold;
use crate::support::program::{directory, program, write};

#[test]
fn its_code_is_the_example() {
    hold(
        "docs/modes.md",
        "```rust\n",
        0..3,
        "examples/rotating_blade.rs",
        true,
    );
    hold(
        "docs/modes.md",
        "```rust\n",
        3..6,
        "examples/cart_pole.rs",
        true,
    );
}

#[test]
fn its_model_has_the_frequencies_stated() {
    let page = include_str!("../../../docs/modes.md");
    let (_, rest) = page.split_once("```toml\n").unwrap();
    let (model, _) = rest.split_once("```").unwrap();
    let out = directory("page of modes");
    let ran = program(&[&write(&out, model)]);
    assert!(
        ran.status.success(),
        "{}",
        String::from_utf8_lossy(&ran.stderr)
    );
    let table = std::fs::read_to_string(out.join("model.out/modes.csv")).unwrap();
    let mode: Vec<f64> = (table.lines().nth(1).unwrap().split(','))
        .map(|x| x.parse().unwrap())
        .collect();
    assert!((mode[1] / 0.559591 - 1.0).abs() < 2e-6, "{mode:?}");
    // The participation of the first mode of a clamped beam: 0.6131 of the mass.
    let effective = mode[9].max(mode[10]).max(mode[11]);
    assert!(
        (mode[9] + mode[10] + mode[11] - 0.6131).abs() < 1e-4,
        "{mode:?} {effective}"
    );
}
