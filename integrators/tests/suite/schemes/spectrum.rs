//! Spectra of the step routine against closed forms and a published table
//! (reference/spectra.json).

use super::WORDS;
use crate::support::*;
use pullback_integrators::spectrum::{
    FirstStep, Numbers, accuracy, amplification, characteristic, closed_form, expansion,
    logarithmic,
};
use serde_json::Value;

fn reference() -> Value {
    serde_json::from_str(include_str!("../../reference/spectra.json")).unwrap()
}

fn scheme(word: &str) -> Scheme {
    word.parse().unwrap()
}

fn by_steps(scheme: &Scheme, Omega: f64) -> [f64; 3] {
    characteristic(amplification(scheme, Omega).unwrap())
}

fn gap(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max)
}

#[test]
fn the_step_routine_has_the_characteristic_polynomials_of_theory() {
    for word in WORDS.into_iter().chain(["tsitouras"]) {
        let scheme = scheme(word);
        // Far beyond its limit an explicit step multiplies rounding errors by Ω⁴.
        let most = scheme.properties().limit.map_or(1e6, |limit| 1.5 * limit);
        for Omega in logarithmic(1e-3, most, 46) {
            let theory = closed_form(&scheme, Omega).unwrap().polynomial;
            let found = by_steps(&scheme, Omega);
            let gap = gap(found, theory);
            assert!(gap < 1e-12, "{word} at {Omega}: {found:?} {theory:?}");
        }
    }
}

#[test]
fn spectral_radius_elongation_and_damping_are_those_of_the_table() {
    let table = reference()["table"].clone();
    let table = table.as_object().unwrap();
    assert_eq!(table.len(), 5);
    for (word, rows) in table {
        let positions = [std::f64::consts::TAU / 10.0, 1.0, 10.0, 100.0];
        let rows = rows.as_array().unwrap();
        assert_eq!(rows.len(), positions.len());
        for (row, Omega) in rows.iter().zip(positions) {
            let Numbers {
                radius,
                damping,
                elongation,
            } = accuracy(&scheme(word), Omega).unwrap().numbers;
            let found = [radius, elongation.unwrap(), damping.unwrap()];
            for (k, found) in found.into_iter().enumerate() {
                let known = row[k].as_f64().unwrap();
                // Half a unit of the tenth decimal, and 1e-12.
                let gap = (found - known).abs();
                assert!(gap <= 0.51e-10, "{word} at {Omega}: {found} {known}");
            }
        }
    }
}

#[test]
fn elongation_and_damping_leave_their_expansions_two_orders_higher() {
    for word in WORDS {
        let scheme = scheme(word);
        if scheme.order() < 2 {
            assert_eq!(expansion(&scheme), None);
            continue;
        }
        let [kappa, sigma] = expansion(&scheme).unwrap();
        let rest: Vec<[f64; 2]> = [0.2, 0.1, 0.05]
            .into_iter()
            .map(|Omega: f64| {
                let numbers = accuracy(&scheme, Omega).unwrap().numbers;
                [
                    numbers.elongation.unwrap() - kappa * Omega.powi(2),
                    numbers.damping.unwrap() - sigma * Omega.powi(3),
                ]
            })
            .collect();
        for (k, order) in [(0, 4.0), (1, 5.0)] {
            let none = rest.iter().all(|r| r[k].abs() < 1e-13);
            let slope = (rest[1][k] / rest[2][k]).abs().log2();
            let off = (slope - order).abs();
            assert!(none || off < 0.2, "{word}: {slope} {rest:?}");
        }
    }
}

#[test]
fn the_trapezoidal_rule_and_the_central_difference_keep_amplitudes() {
    let (implicit, explicit) = (Scheme::default(), Scheme::central_difference());
    let numbers = |scheme: &Scheme, Omega: f64| accuracy(scheme, Omega).unwrap().numbers;
    for half in [0.05, 0.25, 0.5, 0.95_f64] {
        // tan(ω̄h/2) = Ω/2, and sin(ω̄h/2) = Ω/2.
        for (scheme, angle) in [(&implicit, half.atan()), (&explicit, half.asin())] {
            let found = numbers(scheme, 2.0 * half);
            let elongation = half / angle - 1.0;
            assert!((found.elongation.unwrap() - elongation).abs() < 1e-12);
            assert!((found.radius - 1.0).abs() < 1e-14);
        }
    }
    // Beyond Ω = 2 it grows: λ² − (2 − Ω²) λ + 1 = 0.
    let Omega = 2.1_f64;
    let b = 1.0 - 0.5 * Omega * Omega;
    let radius = -b + (b * b - 1.0).sqrt();
    let found = numbers(&explicit, Omega);
    assert!((found.radius - radius).abs() < 1e-12);
    assert_eq!(found.elongation, None);
}

/// A whole step by the routine, against the equations of one step; velocities over ω grow with Ω.
#[test]
fn first_steps_are_those_of_the_closed_form() {
    for word in WORDS.into_iter().chain(["tsitouras"]) {
        for Omega in [1e-3, 0.1, 1.0, 1.9, 10.0, 1e3, 1e7] {
            let scheme = scheme(word);
            let steps = accuracy(&scheme, Omega).unwrap().first_step;
            let closed = closed_form(&scheme, Omega).unwrap().first_step;
            let all = |step: FirstStep| step.from_rest.into_iter().chain(step.from_origin);
            for (found, known) in all(steps).zip(all(closed)) {
                let gap = (found - known).abs() / (1.0 + Omega.max(known.abs()));
                assert!(gap < 1e-12, "{word} at {Omega}: {steps:?} {closed:?}");
            }
        }
    }
}

#[test]
fn impossible_places_are_refused() {
    for Omega in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        refused! { accuracy(&Scheme::default(), Omega) => ["option Omega"] }
    }
}
