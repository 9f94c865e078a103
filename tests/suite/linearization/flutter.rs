//! Flutter of Ziegler's double pendulum (Ziegler 1952; Herrmann & Jong 1965): masses 2m and m, equal springs, a
//! force that follows the second rod.
#![allow(clippy::unwrap_used)]

use crate::support::closures::{GROUND, arm, hinge};
use num_complex::Complex64;
use pullback::input::assemble_text;
use pullback::integrators::linearization::{ModeOptions, linearize, modes};
use pullback::manifold::system::Point;

/// The two eigenvalues λ under a force P, with springs of stiffness 1, dampers, and rods of length 1.
fn eigenvalues(force: f64, damping: f64) -> [Complex64; 2] {
    let spring = format!("spring = {{ k = 1.0, c = {damping:?} }}");
    let mass = |node: &str, mass: f64| {
        format!("[[bodies]]\nname = \"mass of {node}\"\nnode = \"{node}\"\nmass = {mass:?}\n")
    };
    let load = format!(
        "[[loads]]\nnode = \"b\"\nforce = [{:?}, 0, 0]\nfollower = true\ntime = {{ constant = 1 }}\n",
        -force
    );
    let text = [
        GROUND,
        "[analysis.modes]\n",
        &hinge("A", "ground", &spring),
        &arm("a", "A", [1.0, 0.0, 0.0]),
        &hinge("B", "a", &spring),
        &arm("b", "B", [2.0, 0.0, 0.0]),
        &mass("a", 2.0),
        &mass("b", 1.0),
        &load,
    ]
    .concat();
    let mut context = assemble_text("model.toml", &text).unwrap().context;
    let lin = linearize(&mut context, Point::statics(0.0, &[0.0; 2])).unwrap();
    let found = modes(&lin, &ModeOptions::lowest(2)).unwrap();
    assert_eq!((found.modes.len(), found.counted), (2, None));
    [0, 1].map(|k| found.modes[k].eigenvalue)
}

/// A zero of a function between two values of different signs, by bisection.
fn zero(f: impl Fn(f64) -> f64, mut from: f64, mut to: f64) -> f64 {
    let sign = f(from).signum();
    assert!(sign != f(to).signum());
    for _ in 0..60 {
        let middle = 0.5 * (from + to);
        match f(middle).signum() == sign {
            true => from = middle,
            false => to = middle,
        }
    }
    0.5 * (from + to)
}

#[test]
fn two_frequencies_meet() {
    // (ω₁² − ω₂²)² changes its sign.
    let discriminant = |force| {
        let [a, b] = eigenvalues(force, 0.0).map(|x| x * x);
        ((a - b) * (a - b)).re
    };
    let exact = 3.5 - 2.0_f64.sqrt();
    let found = zero(discriminant, 1.0, 3.0);
    assert!((found / exact - 1.0).abs() < 1e-10, "{found} {exact}");
}

#[test]
fn small_dampers_destabilise() {
    let growth = |force| {
        let [a, b] = eigenvalues(force, 1e-4);
        a.re.max(b.re)
    };
    let found = zero(growth, 1.0, 2.0);
    assert!((found / (41.0 / 28.0) - 1.0).abs() < 1e-6, "{found}");
}
