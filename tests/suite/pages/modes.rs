//! The model of docs/modes.md has the numbers that the page states.

use crate::support::included::blocks;
use crate::support::program::{assert_close, csv, directory, ran};

#[test]
fn its_model_has_the_frequencies_stated() {
    let page = include_str!("../../../docs/modes.md");
    let model = blocks(page, "```toml\n")[0];
    let mode = &csv(ran(&directory("page of modes"), model).join("modes.csv"))[0];
    assert_close(mode[1] / 0.559591, 1.0, 2e-6, "frequency");
    // The participation of the first mode of a clamped beam: 0.6131 of the mass.
    assert_close(mode[9] + mode[10] + mode[11], 0.6131, 1e-4, "mass");
}
