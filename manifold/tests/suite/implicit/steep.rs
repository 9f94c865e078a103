//! Laws of a solved constraint near a singular position, where its values have few digits.

#![allow(non_snake_case)]

use nalgebra::{DVector, SVector};
use pullback_conformance::{Layout, Mapped, Random, Report, TestState, kinematics};
use pullback_manifold::domain::DomainError;
use pullback_manifold::implicit::{Choice, Implicit, ImplicitMap};
use pullback_manifold::map::{MapState, Order, Parametrization};
use pullback_manifold::scalar::Scalar;

/// The unit circle.
#[derive(Clone, Copy, Debug)]
struct Circle;

impl Implicit<2, 1> for Circle {
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, 2>) -> SVector<S, 1> {
        SVector::<S, 1>::new(x[0] * x[0] + x[1] * x[1] - 1.0)
    }
}

/// y = √(1 − x²) with a factor at K_σ.
#[derive(Clone)]
struct Steep(ImplicitMap, f64);

impl Parametrization for Steep {
    fn dims(&self) -> (usize, usize) {
        self.0.dims()
    }

    fn domain(&mut self, t: f64, q: &[f64]) -> Result<f64, DomainError> {
        self.0.domain(t, q)
    }

    fn state(&mut self) -> Option<&mut dyn MapState> {
        Some(&mut self.0)
    }

    fn evaluate(&mut self, t: f64, motion: [&[f64]; 3], out: &mut [Order<'_>]) {
        self.0.evaluate(t, motion, out);
    }

    fn geometric_stiffness(&mut self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        self.0.geometric_stiffness(t, q, f, K);
        K[0] *= self.1;
    }
}

/// The laws at an angle from where x has its largest value, by the coordinate x.
fn laws(angle: f64, factor: f64, seed: u64) -> Report {
    let guess = [angle.cos(), angle.sin()];
    let map = ImplicitMap::of(Circle, 1, 0.0, guess, Choice::Fixed).unwrap();
    let map = Steep(map.with_independent(&[0]).unwrap(), factor);
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
            let laws: Vec<&str> = wrong.failures().iter().map(|row| &row.law[..]).collect();
            assert_eq!(laws, ["K_sigma = d(B'f)/dq"], "{angle:e}\n{wrong}");
        }
    }
}
