//! Comparisons of models of the gallery, and the exact motion of its pendulum.
#![allow(non_snake_case, clippy::unwrap_used)]

use nalgebra::Vector3;
use pullback::input::{self, Analysis, ModelFile};
use pullback::studies::compare::{
    CompareError, Comparison, ComparisonOptions, Hooks, Sample, compare,
};
use std::path::Path;

pub fn model(name: &str) -> ModelFile {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models");
    let text = std::fs::read_to_string(path.join(name)).unwrap();
    input::parse(name, &text).unwrap()
}

pub fn until(mut file: ModelFile, to: f64) -> ModelFile {
    match &mut file.analysis {
        Analysis::Dynamic(d) => d.to = to,
        _ => panic!("no motion"),
    }
    file
}

pub fn options(words: &[&str], steps: &[f64]) -> ComparisonOptions {
    let schemes = words.iter().map(|w| w.parse().unwrap());
    ComparisonOptions::new(schemes.collect(), steps.to_vec())
}

pub fn compared(file: &ModelFile, options: &ComparisonOptions) -> Result<Comparison, CompareError> {
    let make = |formulation| input::job("model.toml", file, Some(formulation));
    compare(&make, "model.toml", options, &Hooks::NONE)
}

/// Angle and rate of the pendulum from rest at the horizontal, from the lowest position: a quarter turn
/// of Jacobi's elliptic functions, k = sin 45°, by the descending Landen transformation.
pub fn pendulum(t: f64) -> [f64; 2] {
    let (k, omega) = (0.5_f64.sqrt(), 9.81_f64.sqrt());
    // sin(θ/2) = k cd(ωt): sn at K − u.
    let (mut a, mut b) = (vec![1.0_f64], (1.0 - k * k).sqrt());
    let mut c = vec![k];
    while c.last().unwrap().abs() > 1e-16 {
        let last = *a.last().unwrap();
        c.push(0.5 * (last - b));
        a.push(0.5 * (last + b));
        b = (last * b).sqrt();
    }
    let n = a.len() - 1;
    let K = std::f64::consts::FRAC_PI_2 / a[n];
    let u = K - omega * t;
    let mut phi = 2.0_f64.powi(n as i32) * a[n] * u;
    for i in (1..=n).rev() {
        phi = 0.5 * (phi + (c[i] / a[i] * phi.sin()).asin());
    }
    let (sn, cn) = phi.sin_cos();
    [2.0 * (k * sn).asin(), -2.0 * k * omega * cn]
}

/// Position and velocity of its bob, which begins at −e1.
pub fn bob(sample: &mut Sample) {
    let [theta, rate] = pendulum(sample.t);
    let (sin, cos) = theta.sin_cos();
    // The node of the joint comes first, then that of the rod.
    let rod = sample.nodes.len() - 1;
    sample.nodes[rod].position = Vector3::new(-sin, 0.0, -cos);
    sample.nodes[rod].velocity = Vector3::new(-cos, 0.0, sin) * rate;
    sample.energy = 0.0;
    sample.gross_energy = 1.0;
}
