//! Ranks of constraints: equations that follow from others, and places where the rank changes.

use super::map::{FourBar, GRASHOF};
use crate::support::*;

/// Two equations and combinations of them.
#[derive(Clone, Copy, Debug)]
struct Redundant {
    shift: f64,
}

impl Implicit<4, 4> for Redundant {
    fn h<S: Scalar>(&self, t: S, x: &SVector<S, 4>) -> SVector<S, 4> {
        let first = x[0] * x[0] + x[1] - x[2] * 0.5 - 1.0 + t.sin();
        let second = x[3].sin() + x[2] * x[1];
        let last = x[0] + x[3] - 0.3;
        SVector::<S, 4>::new(first, second, first * 2.0 - second * 3.0 + self.shift, last)
    }

    fn equation(&self, i: usize) -> String {
        ["a", "b", "c", "d"][i].to_owned()
    }
}

#[test]
fn redundant_equations_are_named_and_dropped() {
    let guess = [0.5, 0.7, 0.1, 0.0];
    let at = |t, shift| ImplicitMap::of(Redundant { shift }, 1, t, guess, Choice::Split);
    check::implicit(&at(0.1, 0.0).unwrap(), 0.1).assert();
    let redundant = at(0.0, 0.0).unwrap();
    assert_eq!(redundant.redundant().len(), 1);
    assert!(["a", "b", "c"].contains(&redundant.redundant()[0].as_str()));
    let note = redundant.describe();
    assert!(note.contains("redundant: "), "{note}");
    let error = at(0.0, 1e-3).err().unwrap();
    let ImplicitError::Inconsistent {
        others, residual, ..
    } = &error
    else {
        panic!("{error}");
    };
    assert!(residual.abs() > 1e-4, "{error}");
    assert_eq!(others.len(), "a and b".len(), "{error}");
    // No redundancy where one is expected, and the reverse.
    let error = ImplicitMap::of(GRASHOF, 2, 0.0, [0.4, 0.5, 1.5], Choice::Split);
    let error = error.err().unwrap();
    let too_many = matches!(error, ImplicitError::TooManyEquations { rank: 2, .. });
    assert!(too_many, "{error}");
}

#[test]
fn singular_configurations_are_named() {
    // A parallelogram stretched out flat: both equations' gradients are parallel.
    let flat = FourBar {
        lengths: [1.0, 2.0, 1.0],
        d: 2.0,
        drive: 0.0,
    };
    let split = |linkage, guess| ImplicitMap::of(linkage, 1, 0.0, guess, Choice::Split);
    let error = split(flat, [0.0, 0.0, 0.0]).err().unwrap();
    let text = error.to_string();
    let ImplicitError::Singular { left, expected, .. } = error else {
        panic!("{error}");
    };
    assert_eq!([left, expected], [2, 1]);
    for name in ["closure along", "crank", "coupler", "rocker"] {
        assert!(text.contains(name), "{text}");
    }
    // Run into: margin and words, no panic.
    let mut map = ImplicitMap::of(flat, 1, 0.0, [1.0, 0.0, 1.0], Choice::Fixed).unwrap();
    assert!(map.domain(0.0, &[0.0]).is_ok());
    let q = [-tangent(&map, 0.0, &[0.0])[0][map.independent().unwrap()[0]]];
    let Err(DomainError::Undefined(words)) = map.domain(0.0, &q) else {
        panic!("it has values there");
    };
    assert!(words.contains("closure along"), "{words}");
    let [x, _] = tangent(&map, 0.0, &q);
    assert!(x.iter().all(|x| x.is_nan()));
    // Parts that do not fit together.
    let error = split(FourBar { d: 9.0, ..GRASHOF }, [0.0, 0.0, 3.0]);
    let error = error.err().unwrap();
    assert!(error.to_string().contains("closure along"), "{error}");
    let error = split(GRASHOF, [f64::NAN, 0.0, 3.0]).err().unwrap();
    assert!(matches!(error, ImplicitError::NotFinite { .. }), "{error}");
}

/// Equation c follows from a and b at t = 0, and is off by a little later.
#[derive(Clone, Copy, Debug)]
struct Loosens(f64);

impl Implicit<2, 2> for Loosens {
    fn h<S: Scalar>(&self, t: S, x: &SVector<S, 2>) -> SVector<S, 2> {
        let h = x[0] + x[1] * 2.0;
        SVector::<S, 2>::new(h, h * 3.0 + t * self.0)
    }
}

#[test]
fn an_equation_that_follows_no_more_is_found_by_its_ninth_digit() {
    for (off, holds) in [(1e-10, true), (1e-8, false)] {
        let mut map = ImplicitMap::of(Loosens(off), 1, 0.0, [0.0; 2], Choice::Split).unwrap();
        assert!(map.domain(0.0, &[0.1]).is_ok());
        assert_eq!(map.domain(1.0, &[0.1]).is_ok(), holds, "{off}");
    }
}

#[test]
fn corrections_of_rounding_errors_end_near_a_singular_place() {
    // Corrections of sin α by the rounding errors of the equation are as large as 1e-16 / α.
    let start = 0.1_f64;
    let guess = [start.cos(), start.sin()];
    let map = ImplicitMap::of(Circle, 1, 0.0, guess, Choice::Fixed).unwrap();
    let mut map = map.with_independent(&[0]).unwrap();
    let from = tangent(&map, 0.0, &[0.0])[0][0];
    let mut angle = start;
    while angle > 2e-5 {
        angle *= 0.97;
        let mut q = [angle.cos() - from];
        let inside = map.domain(0.0, &q);
        assert!(inside.is_ok(), "at {angle}: {inside:?}");
        let y = tangent(&map, 0.0, &q)[0][1];
        assert!((y - angle.sin()).abs() < 1e-15 / angle, "at {angle}: {y}");
        assert!(!map.reparametrize(0.0, &mut q, &mut [0.0], &mut []));
    }
}
