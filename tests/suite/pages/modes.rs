//! The model of docs/modes.md has the numbers that the page states.
#![allow(clippy::unwrap_used)]

use crate::support::program::{directory, ran, read};

#[test]
fn its_model_has_the_frequencies_stated() {
    let page = include_str!("../../../docs/modes.md");
    let (_, rest) = page.split_once("```toml\n").unwrap();
    let (model, _) = rest.split_once("```").unwrap();
    let table = read(ran(&directory("page of modes"), model).join("modes.csv"));
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
