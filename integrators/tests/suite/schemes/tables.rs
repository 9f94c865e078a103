//! Words, tables and limits of the schemes.

use crate::support::dynamics::*;
use crate::support::*;
use pullback_integrators::dynamics::scheme::{SCHEMES, STAGES};

#[test]
fn words_make_schemes_and_schemes_say_their_words() {
    for (word, scheme) in [
        ("newmark", Scheme::default()),
        ("newmark:0.3025:0.6", Scheme::newmark(0.3025, 0.6).unwrap()),
        ("hht:-0.1", Scheme::hht(-0.1).unwrap()),
        ("hht:0", Scheme::hht(0.0).unwrap()),
        ("wbz:0.8", Scheme::wbz(0.8).unwrap()),
        ("ga:0.8", Scheme::chung_hulbert(0.8).unwrap()),
        ("bathe:0.5", Scheme::bathe(0.5).unwrap()),
        ("radau", Scheme::radau()),
        ("central-difference", Scheme::central_difference()),
        ("tsitouras", Scheme::tsitouras()),
    ] {
        assert_eq!(word.parse::<Scheme>().unwrap(), scheme);
        assert_eq!(scheme.to_string(), word);
    }
    // 2 − √2 is where both substeps have the same tangent.
    let bathe: Scheme = "bathe".parse().unwrap();
    assert_eq!(bathe.to_string(), "bathe");
    assert!((bathe.stages()[0].c - (2.0 - 2.0_f64.sqrt())).abs() < 1e-15);
    for word in ["generalised-alpha:1", "generalized-alpha:1"] {
        let long: Scheme = word.parse().unwrap();
        assert_eq!(long, Scheme::chung_hulbert(1.0).unwrap());
    }
    // HHT by its spectral radius (1 + α)/(1 − α): 0.8 is α = −1/9, 1/2 the smallest.
    let by_radius: Scheme = "hht:0.8".parse().unwrap();
    let alpha_f = by_radius.coefficients().unwrap().alpha_f;
    assert!((alpha_f - 1.0 / 9.0).abs() < 1e-15);
    assert!("hht:0.5".parse::<Scheme>().is_ok());
    assert_eq!(by_radius.to_string(), "hht:0.8");
    // Hughes 1987, table 9.1.1: √12 with linear acceleration, √6 after Fox & Goodwin; 1/√(γ/2 − β).
    for (beta, gamma, limit) in [
        (1.0 / 6.0, 0.5, Some(12.0_f64.sqrt())),
        (1.0 / 12.0, 0.5, Some(6.0_f64.sqrt())),
        (0.25, 0.6, Some(20.0_f64.sqrt())),
        (0.25, 0.5, None),
        (0.3, 0.6, None),
    ] {
        let scheme = Scheme::newmark(beta, gamma).unwrap();
        assert!((scheme.cubic_error() - (beta - 1.0 / 6.0)).abs() < 1e-15);
        let claimed = scheme.properties().limit;
        let gap = claimed.zip(limit).map(|(a, b)| (a - b).abs());
        assert_eq!(claimed.is_some(), limit.is_some(), "{beta} {gamma}");
        assert!(gap.is_none_or(|gap| gap < 1e-12), "{claimed:?} {limit:?}");
    }
}

#[test]
fn words_that_make_none_are_refused_with_what_there_is() {
    let of = |word: &str| word.parse::<Scheme>();
    refused! {
        of("") => ["no scheme has this name", "ga:RHO", "bathe (gamma"],
        of("Newmark") => ["scheme `Newmark`: no scheme has this name"],
        of("ga") => ["0 numbers are given", "ga:RHO with the spectral radius in [0, 1]"],
        of("ga:1.5") => ["rho of Chung-Hulbert = 1.5 is outside its range [0, 1]"],
        of("ga:nan") => ["rho of Chung-Hulbert = NaN"],
        of("hht:-0.4") => ["alpha of HHT = -0.4 is outside its range [-0.3333333, 0]"],
        of("hht:0.3") =>
            ["rho of HHT (or alpha, which is not positive) = 0.3 is outside its range [0.5, 1]"],
        of("newmark:0.25:0.4") => ["Newmark's gamma = 0.4 is outside its range [0.5, 1]"],
        of("newmark:0:0.5") => ["Newmark's beta = 0.0 is outside its range [0.01, 1]"],
        of("wbz:1.1") => ["rho of WBZ = 1.1"],
        of("hht:-0.1:2") => ["2 numbers are given", "hht:ALPHA"],
        of("wbz:x") => ["scheme `wbz:x`: `x` is not a number"],
        of("bathe:1") => ["gamma of Bathe = 1.0 is outside its range [0.01, 0.99]"],
        of("radau:2") => ["one number is given; it is used as radau"],
    }
    for family in SCHEMES {
        assert!(family.usage.starts_with(family.word), "{}", family.usage);
    }
}

#[test]
fn tables_that_are_none_are_refused() {
    let good = Stage::new(1.0, [0.0, 1.0], [0.0, 1.0]);
    assert!(Scheme::new("Euler", &[good], stable(1)).is_ok());
    let Stage { q, .. } = Stage::new(1.0, [0.0, 1.0, 1.0], [0.0, 1.0, 0.0]);
    let new = |stages: &[Stage]| Scheme::new("trial", stages, stable(1));
    refused! {
        new(&[]) => ["no stages"],
        new(&[good; STAGES + 1]) => ["more than `STAGES`"],
        new(&[Stage { c: 0.5, ..good }]) => ["the last one at c = 1"],
        new(&[Stage { c: f64::NAN, ..good }]) => ["not finite"],
        new(&[Stage { q, ..good }]) => ["a stage that it does not have"],
        new(&[Stage { v: q, ..good }]) => ["a stage that it does not have"],
        new(&[Stage { q, ..good }; 2]) => ["singular"],
        Scheme::new("bathe", &[good], stable(1)) => ["has this name"],
        Scheme::new("ga:0.8", &[good], stable(1)) => ["has this name"],
    }
}

#[test]
fn spectral_radii_at_infinity_are_those_of_the_schemes() {
    for (word, radius) in [
        ("newmark", 1.0),
        ("hht:0.8", 0.8),
        ("wbz:0.3", 0.3),
        ("ga:0.6", 0.6),
        ("ga:0", 0.0),
        ("projected-newmark", 1.0),
        ("projected-newmark:0.6", 0.6),
        ("bathe", 0.0),
        ("radau", 0.0),
        ("central-difference", f64::INFINITY),
        ("tsitouras", f64::INFINITY),
    ] {
        let found = word.parse::<Scheme>().unwrap().spectral_radius();
        // A double root is known to the square root of rounding errors.
        let near = found == radius || (found - radius).abs() < 1e-7;
        assert!(near, "{word}: {found}");
    }
}
