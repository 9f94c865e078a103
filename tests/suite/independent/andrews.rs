//! Andrews' squeezer mechanism in coordinates of every choice; `tests/studies` takes it to the published digits.

use crate::support::andrews::*;
use pullback::conformance as check;
use pullback::manifold::implicit::Choice;

#[test]
fn the_loops_obey_the_laws() {
    for choice in [Choice::Split, Choice::Tangent] {
        check::implicit(&loops(choice), 0.0).assert();
    }
}

#[test]
fn all_choices_of_coordinates_give_the_same_motion() {
    assert_choices([400, 800, 1600], &by_midpoints(60));
}
