//! Comparisons of schemes against exact solutions.

use crate::support::comparisons::{self, BODY, assert_observed, oscillator, precession};
use crate::support::laboratory::options;
use crate::support::program::{assert_close, assert_says, changed, directory, example, json, read};
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use pullback::input;
use pullback::studies::compare::{
    Comparison, ComparisonOptions, ComparisonRow, ErrorQuantity, Hooks, Sample, Values, compare,
    run,
};
use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

fn compared(text: &str, options: &ComparisonOptions) -> Comparison {
    comparisons::compared(text, options).unwrap()
}

/// Root mean square over the samples after the start.
fn rms(samples: &[Sample], distance: impl Fn(&Sample) -> f64) -> f64 {
    let samples = &samples[1..];
    let sum: f64 = samples.iter().map(|s| distance(s).powi(2)).sum();
    (sum / samples.len() as f64).sqrt()
}

/// A free body that starts turned.
fn body() -> String {
    let turned = "body_angular_velocity => rotation = [0.4, -0.9, 0.6]\\n&";
    changed(BODY, turned)
}

/// Its rotation at the start, which turns its motion as a whole.
fn turned() -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(Vector3::new(0.4, -0.9, 0.6))
}

/// How far a sample is from the exact motion.
type Distance = fn(&Sample) -> f64;

/// The angle between its rotation and that of its precession.
fn rotation_error(s: &Sample) -> f64 {
    let found = Rotation3::from_matrix_unchecked(s.nodes[0].R);
    let [_, exact] = precession(s.t);
    UnitQuaternion::from(found).angle_to(&(turned() * exact))
}

/// ω goes round the fixed angular momentum: its rate is a cross product with it.
fn acceleration_error(s: &Sample) -> f64 {
    let [round, _] = precession(s.t);
    let omega = round * Vector3::new(3.0, 0.0, 4.0);
    let exact = turned() * Vector3::new(3.0, 0.0, 2.0).cross(&omega);
    (s.nodes[0].omega_dot - exact).norm()
}

/// A reference by sums of spins has nothing in common with the rotation vectors of the schemes, and the same
/// exact motion.
#[test]
fn a_reference_has_a_formulation_of_its_own() {
    let asked = ComparisonOptions {
        reference: Some("lie-ga:0.8".parse().unwrap()),
        ..options(&["newmark"], &[0.02, 0.01])
    };
    let comparison = compared(&body(), &asked);
    let reference = comparison.reference.as_ref().unwrap();
    assert_eq!(reference.scheme, "lie-ga:0.8");
    // Charts of increments are centred in every step, those of rotation vectors change a few times.
    let changes = reference.chart_changes;
    assert!(changes >= 1600, "{changes}");
    let own = rms(&reference.samples, rotation_error);
    let estimate = reference.error.of(ErrorQuantity::Rotation);
    assert!(own <= estimate && estimate < 1e-5, "{own} {estimate}");
}

#[test]
fn a_free_body_converges_to_its_exact_precession_by_every_method() {
    let all = "newmark hht:-0.1 wbz:0.8 ga:0.8 radau newmark:0.3025:0.6 ul-newmark ul-hht:-0.1 ul-wbz:0.8 ul-bathe \
               lie-ga:0.8 lie-hht:-0.1 spin-newmark wm-newmark";
    let all: Vec<&str> = all.split(' ').collect();
    let comparison = compared(&body(), &options(&all, &[0.01, 0.005, 0.0025, 0.00125]));
    let reference = comparison.reference.as_ref().unwrap();
    assert!(reference.extrapolated.0[ErrorQuantity::Rotation as usize]);
    // The start is exact, and belongs to the mean.
    let share = (comparison.times as f64 / (comparison.times + 1) as f64).sqrt();
    let errors: [(_, Distance); 2] = [
        (ErrorQuantity::Rotation, rotation_error),
        (ErrorQuantity::AngularAcceleration, acceleration_error),
    ];
    for (quantity, error) in errors {
        let own = rms(&reference.samples, error);
        // The estimate is an upper bound.
        let estimate = reference.error.of(quantity);
        assert!(own <= estimate, "{own} {estimate}");
        for row in &comparison.rows {
            assert_eq!(row.failure, None, "{} {}", row.scheme, row.step);
            assert!(row.counts.chart_changes >= 2);
            let found = rms(&row.samples, error) * share;
            let said = row.error.unwrap().of(quantity);
            let within = (found - said).abs() <= estimate + 1e-13;
            assert!(within, "{}: {found} {said}", row.scheme);
        }
    }
    assert!(reference.error.of(ErrorQuantity::Rotation) < 1e-6);
    for scheme in &comparison.orders {
        let theory = match scheme.scheme.as_str() {
            "radau" => 3,
            "newmark:0.3025:0.6" => 1,
            _ => 2,
        };
        assert_eq!(scheme.theory, Some(Values([theory; 7])));
        for quantity in [
            ErrorQuantity::Rotation,
            ErrorQuantity::AngularVelocity,
            ErrorQuantity::AngularAcceleration,
        ] {
            assert_observed(&comparison, &scheme.scheme, quantity, theory as f64, 0.1);
        }
        // It rests at its place.
        assert_eq!(scheme.of(ErrorQuantity::Position), None);
    }
    // A free body keeps everything.
    let kept = reference.conserved;
    assert!(kept.energy && kept.momentum == [true; 3] && kept.angular_momentum == [true; 3]);
}

#[test]
fn errors_of_the_trapezoidal_rule_on_an_oscillator_are_those_in_closed_form() {
    let steps = [0.1, 0.05, 0.025];
    let comparison = compared(&oscillator(), &options(&["newmark", "ga:0.8"], &steps));
    let estimate = comparison.reference.as_ref().unwrap().error;
    assert_eq!((comparison.times, comparison.unknowns), (80, 1));
    for row in comparison.of("newmark") {
        // x_n = 0.3 cos(nφ) with tan(φ/2) = ωh/2; velocity −0.3 ω sin(nφ), as the energy stays.
        let phase = 2.0 * (2.0 * row.step / 2.0).atan() / row.step;
        let x = |s: &Sample| 0.3 * ((phase * s.t).cos() - (2.0 * s.t).cos());
        let v = |s: &Sample| 0.6 * ((phase * s.t).sin() - (2.0 * s.t).sin());
        // Of the two nodes the ground has no error; nor has the start.
        let share = (0.5 * 80.0 / 81.0_f64).sqrt();
        let error = row.error.unwrap();
        for (quantity, exact) in [
            (ErrorQuantity::Position, rms(&row.samples, x)),
            (ErrorQuantity::Velocity, rms(&row.samples, v)),
            (ErrorQuantity::Acceleration, 4.0 * rms(&row.samples, x)),
        ] {
            let allowed = 2.0 * estimate.of(quantity) + 1e-9;
            let what = format!("{} with {}", quantity.name(), row.step);
            assert_close(error.of(quantity), share * exact, allowed, what);
        }
        // The trapezoidal rule keeps a quadratic energy (0.18); generalised-alpha damps it.
        assert!(row.drift.energy.unwrap() < 1e-9);
    }
    let mut damped = comparison.of("ga:0.8");
    assert!(damped.all(|row| row.drift.energy.unwrap() > 1e-7));
    for scheme in &comparison.orders {
        let quantity = ErrorQuantity::Position;
        assert_observed(&comparison, &scheme.scheme, quantity, 2.0, 0.02);
        assert_eq!(scheme.of(quantity).unwrap().points, 3);
    }
}

#[test]
fn momenta_that_are_zero_in_a_plane_are_no_merit() {
    // The pendulum swings about e2: its momentum has no component there, its angular momentum no other one.
    let both = options(&["newmark", "projected-newmark"], &[0.02, 0.01]);
    let pendulum = changed(&example("pendulum"), "to = 10 => to = 0.5");
    let comparison = compared(&pendulum, &both);
    let zero = [[false, true, false], [true, false, true]];
    assert_eq!(comparison.zero_momenta, zero);
    let kept = comparison.reference.as_ref().unwrap().conserved;
    assert!(kept.momentum[1] && kept.angular_momentum[0]);
    for row in &comparison.rows {
        let drift = &row.drift;
        assert_eq!([drift.momentum, drift.angular_momentum], [None; 2]);
        assert!(drift.energy.is_some());
        // Nor has it loops.
        assert_eq!(drift.violation, None);
    }
    // A free body in space has no such component.
    let body = changed(&example("free_body"), "to = 8 => to = 0.1");
    let comparison = compared(&body, &options(&["newmark"], &[0.004, 0.002]));
    assert_eq!(comparison.zero_momenta, [[true; 3], [false; 3]]);
    assert!(comparison.rows[0].drift.angular_momentum.is_some());
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    // Three runs of the reference and two of the scheme go on all cores unless told otherwise.
    let all = compared(BODY, &options(&["newmark"], &[0.04, 0.02]));
    let cores = std::thread::available_parallelism().unwrap().get();
    assert_eq!(all.threads, cores.min(3 + 2));
    let with = |threads: usize| {
        let threads = NonZeroUsize::new(threads);
        let options = options(&["newmark", "ga:0.8"], &[0.04, 0.02]);
        let comparison = compared(BODY, &ComparisonOptions { threads, ..options });
        let samples: Vec<_> = comparison.rows.iter().map(|r| r.samples.clone()).collect();
        let mut value = serde_json::to_value(&comparison).unwrap();
        value["threads"] = 0.into();
        for row in value["rows"].as_array_mut().unwrap() {
            row["seconds"] = 0.into();
        }
        (samples, value)
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
}

#[test]
fn a_scheme_that_fails_at_a_step_is_a_row_with_the_reason() {
    // Stable up to h = 2/ω = 1.
    let text = oscillator().replace("to = 8", "to = 60");
    let asked = options(&["central-difference", "newmark"], &[1.2, 0.12, 0.06]);
    let comparison = compared(&text, &asked);
    let failed = comparison.rows.iter().filter(|r| r.failure.is_some());
    let failed: Vec<&ComparisonRow> = failed.collect();
    let [row] = failed[..] else {
        panic!("{failed:?}");
    };
    let run = (&row.scheme[..], row.requested_step);
    assert_eq!(run, ("central-difference", 1.2));
    assert_says(row.failure.as_deref().unwrap(), &["too large"]);
    assert!(row.error.is_none() && !row.is_regular());
    assert!(comparison.complete && comparison.reference.is_some());
    // The others are there, and make an order.
    let quantity = ErrorQuantity::Position;
    assert_observed(&comparison, "central-difference", quantity, 2.0, 0.1);
    assert_eq!(comparison.orders[0].of(quantity).unwrap().points, 2);
}

#[test]
fn a_comparison_of_nothing_is_refused() {
    let refused = comparisons::compared(BODY, &options(&[], &[0.1, 0.05]));
    assert_says(&refused.unwrap_err().to_string(), &["no scheme"]);
}

#[test]
fn a_comparison_that_is_stopped_keeps_what_it_has_and_says_so() {
    let directory = directory("compare_stopped");
    let file = input::parse("model.toml", BODY).unwrap();
    let make = |formulation| input::job("model.toml", &file, Some(formulation));
    // The reference makes 5600 steps, the others 600.
    let steps = AtomicUsize::new(0);
    let watch = Hooks {
        flow: &|| match steps.fetch_add(1, Ordering::Relaxed) {
            0..5800 => ControlFlow::Continue(()),
            _ => ControlFlow::Break(()),
        },
        ..Hooks::NONE
    };
    let options = ComparisonOptions {
        threads: NonZeroUsize::new(1),
        ..options(&["newmark", "ga:0.8"], &[0.02, 0.01, 0.005])
    };
    let comparison = run(&make, "model.toml", None, &directory, &options, &watch).unwrap();
    assert!(!comparison.complete);
    let stopped = |row: &&ComparisonRow| row.failure.as_deref() == Some("interrupted");
    assert!(comparison.rows.iter().any(|row| stopped(&row)));
    assert!(comparison.reference.is_some());
    let read = |name: &str| read(directory.join(name));
    assert_eq!(json(directory.join("compare.json"))["complete"], false);
    assert!(read("compare.csv").contains(",interrupted,"));
    assert!(read("compare.html").contains("was interrupted"));
}

#[test]
fn refusals_come_before_runs() {
    let file = input::parse("pendulum.toml", &example("pendulum")).unwrap();
    let make = |formulation| input::job("pendulum.toml", &file, Some(formulation));
    let told = Mutex::new(Vec::new());
    let watch = Hooks {
        refused: &|name, why| told.lock().unwrap().push(format!("{name}: {why}")),
        ended: &|_, _, name| told.lock().unwrap().push(name.to_owned()),
        ..Hooks::NONE
    };
    let schemes = ["newmark", "lie-ga:0.8", "ga:0.8", "ul-newmark"];
    let options = options(&schemes, &[0.2, 0.1]);
    compare(&make, "pendulum.toml", &options, &watch).unwrap();
    let told = told.into_inner().unwrap();
    for (said, name) in told.iter().zip(["lie-ga:0.8: ", "ul-newmark: "]) {
        assert!(said.starts_with(name), "{told:?}");
        assert_says(said, &["without the prefix"]);
    }
    // Three runs of the reference and eight of the schemes follow.
    assert_eq!(told.len(), 2 + 3 + 8, "{told:?}");
}
