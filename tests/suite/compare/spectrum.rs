//! `pullback spectrum`: its table, its files, what it refuses.

use crate::support::drawings::tagged;
use crate::support::program::*;
use roxmltree::Document;

#[test]
fn files_say_what_theory_says() {
    let directory = directory("spectrum");
    let table = printed(&directory, "spectrum --out out");
    assert_says(&table, &["central-difference"]);
    let read = |name: &str| read(directory.join("out").join(name));
    let json = || json(directory.join("out/spectrum.json"));
    let first = json();
    let command = first["command"].as_str().unwrap();
    assert!(command.starts_with("pullback spectrum --out"), "{command}");
    let schemes = first["schemes"].as_array().unwrap();
    assert_eq!(schemes.len(), 7);
    let mut lines = 1;
    for scheme in schemes {
        // By steps and in closed form.
        let defect = scheme["defect"].as_f64().unwrap();
        assert!(defect < 1e-12, "{}", scheme["scheme"]);
        lines += scheme["points"].as_array().unwrap().len();
    }
    let csv = read("spectrum.csv");
    assert_eq!(csv.lines().count(), lines);
    let columns = csv.lines().map(|line| line.split(',').count());
    assert!(columns.into_iter().all(|count| count == 18));
    // The trapezoidal rule: tan(ω̄h/2) = Ω/2, no damping, q₁/q₀ = (4 − Ω²)/(4 + Ω²).
    for point in schemes[0]["points"].as_array().unwrap() {
        let number = |key: &str| point[key].as_f64().unwrap();
        let omega = number("Omega");
        let elongation = omega / (2.0 * (0.5 * omega).atan()) - 1.0;
        // Eigenvalues lie as close as 2Ω to each other, or to −1.
        let close = 1e-14 * (1.0 / (omega * omega) + omega * omega);
        assert!((number("elongation") - elongation).abs() < close, "{omega}");
        assert!((number("radius") - 1.0).abs() < 1e-12);
        let square = omega * omega;
        assert!((number("rest_position") - (4.0 - square) / (4.0 + square)).abs() < 1e-12);
    }
    for figure in ["spectrum.svg", "overshoot.svg"] {
        let text = read(figure);
        let lines = tagged(&Document::parse(&text).unwrap(), "polyline").count();
        assert!(lines > 14, "{figure}: {lines} lines");
    }
    // Nothing of an earlier call stays.
    printed(&directory, "spectrum --schemes bathe --out out");
    assert_eq!(json()["schemes"].as_array().unwrap().len(), 1);
}

#[test]
fn a_range_without_files_is_noted() {
    let directory = directory("spectrum_range");
    for (arguments, noted) in [(" --from 1", true), ("", false)] {
        let line = format!("spectrum --schemes newmark{arguments}");
        let said = succeeded(&program_in(&directory, &line));
        let words = "--from and --to apply to the files";
        assert_eq!(said.contains(words), noted, "{said}");
    }
}

#[test]
fn what_it_refuses() {
    check_lines(
        &directory("spectrum_refused"),
        "spectrum",
        "
--schemes ga:2 | rho of Chung-Hulbert = 2.0 is outside its range
--schemes gaa | scheme `gaa`: no scheme has this name; there are
--schemes newmark,lie-ga:0.8 | do not affect a linear vibration: leave the prefix out, `ga:0.8`
--schemes projected-newmark:0.5 | that of its step is the one of `ga:0.5`
--schemes projected-newmark | that of its step is the one of `newmark`
--schemes diffsol-bdf | `diffsol-bdf` is a general solver
--schemes newmark,bathe,newmark:0.25:0.5 | scheme `newmark` is given twice
--from -1 | Ω from -1 to 1000 is not a range
--from 10 --to 1 | Ω from 10 to 1 is not a range
",
    );
}
