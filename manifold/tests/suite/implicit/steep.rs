//! Laws of a solved constraint near a singular position, where its values have few digits.

use super::Planted;
use crate::support::*;
use pullback_conformance::kinematics;

/// The laws at an angle from where x has its largest value, by the coordinate x.
fn laws(angle: f64, factor: f64, seed: u64) -> Report {
    let guess = [angle.cos(), angle.sin()];
    let map = ImplicitMap::of(Circle, 1, 0.0, guess, Choice::Fixed).unwrap();
    let map = Planted {
        map: map.with_independent(&[0]).unwrap(),
        B_dot: 1.0,
        K: factor,
    };
    let mut report = Report::new("circle");
    let [x, v, a] = [0.0, 0.0, 0.0].map(|x| DVector::from_element(1, x));
    let of = Mapped {
        map: &map,
        rows: &Layout::plain(2),
        columns: &Layout::plain(1),
    };
    let state = TestState { t: 0.0, x, v, a };
    kinematics(&mut report, "", of, "there", &state, &mut Random::new(seed));
    report
}

#[test]
fn a_steep_place_raises_no_alarm_and_hides_no_error() {
    // Nearer than that one per cent of K_sigma is less than rounding makes of it.
    for exponent in 1..=3 {
        let angle = 10_f64.powi(-exponent);
        for seed in 0..40 {
            laws(angle, 1.0, seed).assert();
            let wrong = laws(angle, 1.01, seed);
            let laws = wrong.failing_laws();
            assert_eq!(laws, ["K_sigma = d(B'f)/dq"], "{angle:e}\n{wrong}");
        }
    }
}
