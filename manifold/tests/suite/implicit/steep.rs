//! Laws of a solved constraint near a singular position, where its values have few digits.

#![allow(non_snake_case)]

use nalgebra::{DVector, SMatrix, SVector};
use pullback_conformance::{Layout, Mapped, Random, Report, State, kinematics};
use pullback_manifold::implicit::{Choice, Implicit, Solved};
use pullback_manifold::map::{Kinematics, Map};
use pullback_manifold::scalar::Scalar;

/// The unit circle.
#[derive(Clone, Copy, Debug)]
struct Circle;

impl Implicit<2, 1> for Circle {
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, 2>) -> SVector<S, 1> {
        SVector::<S, 1>::new(x[0] * x[0] + x[1] * x[1] - 1.0)
    }
}

type OnCircle = Solved<Circle, 1, 2, 1>;

/// y = √(1 − x²) with a factor at K_σ.
#[derive(Clone)]
struct Steep(OnCircle, f64);

impl Map<1, 2> for Steep {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, 1>) -> SVector<S, 2> {
        self.0.phi(t, q)
    }

    fn margin(&self, t: f64, q: &SVector<f64, 1>) -> f64 {
        self.0.margin(t, q)
    }

    fn violation(&self, t: f64, q: &SVector<f64, 1>) -> Option<f64> {
        self.0.violation(t, q)
    }

    fn kinematics(
        &self,
        t: f64,
        q: &SVector<f64, 1>,
        v: &SVector<f64, 1>,
        a: &SVector<f64, 1>,
    ) -> Kinematics<1, 2> {
        Map::<1, 2>::kinematics(&self.0, t, q, v, a)
    }

    fn geometric_stiffness(
        &self,
        t: f64,
        q: &SVector<f64, 1>,
        f: &SVector<f64, 2>,
    ) -> SMatrix<f64, 1, 1> {
        Map::<1, 2>::geometric_stiffness(&self.0, t, q, f) * self.1
    }
}

/// The laws at an angle from where x has its largest value, by the coordinate x.
fn laws(angle: f64, factor: f64, seed: u64) -> Report {
    let guess = [angle.cos(), angle.sin()];
    let solved = OnCircle::with(Circle, 0.0, guess, Choice::Fixed).unwrap();
    let map = Steep(solved.with_independent(0.0, [0]).unwrap(), factor);
    let mut report = Report::new("circle");
    let [x, v, a] = [0.0, 0.0, 0.0].map(|x| DVector::from_element(1, x));
    let of = Mapped {
        map: &*map.boxed(),
        rows: &Layout::plain(2),
        columns: &Layout::plain(1),
    };
    let state = State { t: 0.0, x, v, a };
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
