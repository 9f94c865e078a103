//! Andrews' squeezer mechanism to the published digits, by the program and by the equations of the test set.
#![allow(non_snake_case, clippy::unwrap_used)]

use crate::support::andrews::*;
use crate::support::independent::assert_published;
use pullback::manifold::implicit::Choice;

#[test]
fn extrapolated_to_the_published_digits() {
    let map = loops(Choice::Fixed).with_independent(&[0]).unwrap();
    let runs = [1500, 3000, 6000].map(|n| {
        let run = run(&map, n);
        assert!(run.residual < 1e-15, "{:e}", run.residual);
        run.end
    });
    let (reference, rows) = reference();
    println!("errors {:?}", runs.map(|r| errors(&r, &reference)));
    // The trapezoidal rule is symmetric: its errors have even powers of the step.
    let mix = |coarse: &Angles, fine: &Angles, power: f64| -> Angles {
        std::array::from_fn(|d| {
            std::array::from_fn(|k| fine[d][k] + (fine[d][k] - coarse[d][k]) / (power - 1.0))
        })
    };
    let once = [mix(&runs[0], &runs[1], 4.0), mix(&runs[1], &runs[2], 4.0)];
    let twice = mix(&once[0], &once[1], 16.0);
    let found = errors(&twice, &reference);
    println!("extrapolated {found:?}");
    assert!(found[0] < 5e-10 && found[1] < 1e-9, "{found:?}");
    // So do the test set's equations, integrated explicitly; the published beta is above both.
    let explicit = [100, 200].map(by_midpoints);
    let explicit = explicit.map(|[angles, ..]| angles);
    let beta = |x: f64| (reference[0][0] - x) / reference[0][0];
    println!(
        "beta below: {:e} {:e}",
        beta(explicit[1][0]),
        beta(twice[0][0])
    );
    let (own, ours) = (
        gap(&explicit[0], &explicit[1]),
        gap(&twice[0], &explicit[1]),
    );
    println!("half the step {own:e}, the program {ours:e}");
    assert!(own < 1e-12 && ours < 1e-11, "{own:e} {ours:e}");
    for beta in [beta(explicit[1][0]), beta(twice[0][0])] {
        assert!((6e-11..8e-11).contains(&beta), "{beta:e}");
    }
    // The published accelerations are those of a method that integrates them, and 1.0e-7 off those
    // that follow from the published angles and rates.
    let [q, v, a] = reference;
    let exact = accelerations(&q, &v);
    let published = gap(&a, &exact);
    let ours = gap(&twice[2], &exact);
    println!("accelerations: published {published:.2e}, found {ours:.2e}");
    assert!((0.9e-7..1.1e-7).contains(&published), "{published:e}");
    assert_published(&rows, "following", &exact, 1e-6);
    assert!(found[2] < 1.2e-7 && ours < 5e-9, "{found:?}, {ours:e}");
}

#[test]
fn all_choices_of_coordinates_give_the_same_motion() {
    assert_choices([750, 1500, 3000], &reference().0);
}
