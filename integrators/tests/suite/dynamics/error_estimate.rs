//! The estimate of the local error beside the error that a step has.

use crate::support::dynamics::*;
use crate::support::*;

const OMEGA: f64 = 2.0;

/// The estimate over the error of q in a step of size h of q̈ = −ω² q from the time ¼ on, until when
/// the algorithmic acceleration, which starts as q̈, has settled; the estimate is read from the size
/// that the next step is given.
fn estimate_over_error(scheme: Scheme, h: f64) -> f64 {
    let equal = steps_of(scheme, 0.25, h);
    let oscillator = || Oscillator::new(1.0, OMEGA * OMEGA);
    let before = run(oscillator(), 0.7, -1.1, &equal);
    let step = |tolerance: f64| {
        let options = adaptive(steps_of(scheme, 0.25 + h, h), tolerance, 1.0);
        let mut progress = before.clone();
        integrate(&mut oscillator(), &mut progress, &options, &mut onward).unwrap();
        assert_eq!(progress.summary.steps, before.summary.steps + 1);
        assert_eq!(progress.summary.inaccurate, 0);
        progress
    };
    let (sin, cos) = (OMEGA * h).sin_cos();
    let exact = before.state.q[0] * cos + before.state.v[0] / OMEGA * sin;
    let error = (step(1.0).state.q[0] - exact).abs();
    // With a tolerance near the error the size of the next step is at neither of its limits.
    let tolerance = 1.5 * error;
    let factor = step(tolerance).next_step / h;
    assert!(factor > 0.3 && factor < 2.0, "at a limit: {factor}");
    tolerance * (0.9 / factor).powi(3) / error
}

#[test]
fn the_estimate_is_the_local_error_of_small_steps() {
    let newmark = Scheme::newmark(0.3, 0.5).unwrap();
    for scheme in schemes().into_iter().chain([newmark]) {
        let gaps = [128.0, 256.0, 512.0, 1024.0]
            .map(|n| (estimate_over_error(scheme, 1.0 / n) - 1.0).abs());
        // It tends to the error with h.
        for (slope, within) in slopes(&gaps).into_iter().zip([0.1, 0.05, 0.03]) {
            assert!((slope - 1.0).abs() < within, "{scheme}: {gaps:?}");
        }
        assert!(gaps[3] < 0.01, "{scheme}: {gaps:?}");
    }
}

#[test]
fn embedded_rows_that_estimate_nothing_and_contradicting_steps_are_refused() {
    let tsitouras = Scheme::tsitouras();
    let main = *tsitouras.stages().last().unwrap();
    let nan = Stage {
        c: f64::NAN,
        q: main.q.map(|_| f64::NAN),
        ..main
    };
    let early = Stage {
        c: 0.3,
        ..*tsitouras.embedded().unwrap()
    };
    let euler = Stage::runge_kutta([1.0], [[0.0, 1.0]]);
    let euler = Scheme::new("backward Euler", &euler, stable(1)).unwrap();
    let beyond = Stage::new(1.0, [0.0, 0.5, 0.0], [0.0, 0.5, 0.5]);
    let trial = |scheme: Scheme, max_step: f64| {
        let options = adaptive(steps_of(scheme, 1.0, 0.1), 1e-6, max_step);
        attempt(&mut Oscillator::new(1.0, 4.0), [&[1.0], &[0.0]], &options)
    };
    trial(tsitouras, 1.0).unwrap();
    refused! {
        trial(tsitouras.with_embedded(main), 1.0) => ["embedded row"],
        trial(tsitouras.with_embedded(nan), 1.0) => ["embedded row"],
        trial(tsitouras.with_embedded(early), 1.0) => ["embedded row"],
        trial(euler.with_embedded(beyond), 1.0) => ["embedded row"],
        trial(tsitouras, 1e-9) => ["max_step = 1e-9", "at least `min_step`"],
    }
}

#[test]
fn steps_of_order_one_meet_the_tolerance() {
    // Backward Euler: with q̈ = 1 a step of size h is off by h²/2.
    let stages = Stage::runge_kutta([1.0], [[0.0, 1.0]]);
    let scheme = Scheme::new("backward Euler", &stages, stable(1)).unwrap();
    let options = adaptive(steps_of(scheme, 1.0, 0.1), 1e-4, 1.0);
    let size = |step: &StepReport<'_>| step.step_size;
    let (sizes, end) = observed(Oscillator::mass(1.0), 0.0, 0.0, &options, size);
    let most = sizes.iter().fold(0.0_f64, |most, h| most.max(0.5 * h * h));
    assert!((0.5e-4..=1e-4).contains(&most), "{most:e}");
    assert!(end.summary.inaccurate > 0);
}
