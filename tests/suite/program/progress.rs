//! What the line of progress says of a step.

use pullback::integrators::dynamics::Progress;
use pullback::solve::Advance;

fn step(progress: Option<&Progress>) -> Advance<'_> {
    Advance {
        number: 7,
        t: 0.35,
        step_size: 0.0125,
        iterations: 3,
        residuals: &[],
        chart_changes: 0,
        event: None,
        unstable: None,
        progress,
    }
}

#[test]
fn a_step_tells_where_it_is_its_size_and_its_iterations() {
    let motion = Progress::default();
    let said = "step 7  time 0.35  step size 1.250e-2  3 iterations";
    assert_eq!(step(Some(&motion)).describe(), said);
    let still = Advance {
        iterations: 1,
        ..step(None)
    };
    let said = "step 7  load parameter 0.35  step size 1.250e-2  1 iteration";
    assert_eq!(still.describe(), said);
}

#[test]
fn the_part_that_is_done_is_one_at_the_end() {
    for (t, to, part) in [
        (0.0, 3.0, 0.0),
        (0.35, 2.0, 0.175),
        (1.5, 3.0, 0.5),
        (3.0, 3.0, 1.0),
        (3.1, 3.0, 1.0),
        (0.0, 0.0, 1.0),
    ] {
        assert_eq!(Advance { t, ..step(None) }.part(to), part, "{t} of {to}");
    }
}
