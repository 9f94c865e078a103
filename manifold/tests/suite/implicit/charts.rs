//! The charts of implicit constraints with redundant equations and parameters.

use super::linear::Linear;
use crate::support::*;

const LINKS: usize = 5;

/// A chain of bars of length one between two points that are this far apart at t = 0.
#[derive(Clone, Copy, Debug)]
struct Chain(f64);

const CHAIN: Equations<Chain> = Equations(Chain(3.0));

impl Implicit<LINKS, 2> for Chain {
    fn h<S: Scalar>(&self, t: S, x: &SVector<S, LINKS>) -> SVector<S, 2> {
        let mut end = Vector2::new(S::constant(-self.0) - t * 0.1 * t, t * 0.2);
        for x in x.iter() {
            end[0] += x.cos();
            end[1] += x.sin();
        }
        end
    }
}

/// The same as a map of its residuals, and once more their sum and difference.
#[derive(Clone, Copy)]
struct Twice;

impl Map<LINKS, 4> for Twice {
    fn phi<S: Scalar>(&self, t: S, x: &SVector<S, LINKS>) -> SVector<S, 4> {
        let h = CHAIN.phi(t, x);
        SVector::<S, 4>::new(h[0], h[1], h[0] + h[1], h[0] - h[1])
    }
}

const GUESS: [f64; LINKS] = [-1.2, -0.6, 0.3, 0.5, 1.0];
const T: f64 = 0.3;

#[test]
fn the_laws_of_a_map_hold_with_redundant_equations() {
    let map = ImplicitMap::new(Twice.boxed(), about(&GUESS.map(Some), 4), T, &[]).unwrap();
    assert_eq!((map.freedoms(), map.redundant().len()), (3, 2));
    let said = map.describe();
    assert!(said.contains("redundant: "), "{said}");
    check::implicit(&map, T).assert();
}

#[test]
fn parameters_are_independent_coordinates_from_outside() {
    // The first bar is given: (p, x) as one vector.
    let p = GUESS[0];
    let map = ImplicitMap::new(CHAIN.boxed(), about(&GUESS.map(Some)[1..], 2), T, &[p]).unwrap();
    assert_eq!(map.freedoms(), 2);
    for q in [
        [0.0, 0.0, p],
        [0.1, -0.05, p + 0.08],
        [0.3, -0.15, p + 0.24],
    ] {
        let to_first = |m: &mut ImplicitMap, q: &mut [f64], v: &mut [f64], a: &mut [Vec<f64>]| {
            m.switch(T, Some(&[0, 1]), q, v, a)
        };
        check::rewriting(&map, T, &q, &to_first, None).assert();
        // With the bar as it is given, the chain closes.
        let [x, ..] = motion(&map, T, [&q, &[0.0; 3], &[0.0; 3]]);
        let x = SVector::from_fn(|k, _| if k == 0 { q[2] } else { x[k - 1] });
        assert!(CHAIN.0.h(T, &x).norm() < 1e-14, "{x}");
    }
}

#[test]
fn a_change_of_chart_can_be_recalled() {
    let mut fresh = ImplicitMap::new(Twice.boxed(), about(&GUESS.map(Some), 4), T, &[]).unwrap();
    let (mut map, mut q, mut v) = (fresh.clone(), [0.1, -0.2, 0.15], [0.4, -0.7, 1.1]);
    assert!(map.switch(T, None, &mut q, &mut v, &mut []));
    assert!(!fresh.restore(&map.save()[1..]));
    assert!(fresh.restore(&map.save()));
    // The same to the last bit.
    let next = [q[0] + 0.02, q[1], q[2] - 0.01];
    let [one, other] = [&map, &fresh].map(|map| motion(map, T, [&next, &v, &v]));
    assert_eq!(one, other);
}

#[test]
fn what_does_not_close_is_named() {
    // Five bars of length one do not reach 3 + 0.1 t² for t = 6.
    let error = ImplicitMap::new(Twice.boxed(), about(&[None; LINKS], 4), 6.0, &[]);
    let error = error.err().unwrap();
    assert!(error.to_string().contains('h'), "{error}");
    let apart = matches!(error, ImplicitError::NotAssembled { .. });
    assert!(apart, "{error}");
    // Stretched out, the bars can only move sideways: the equations along them say nothing.
    let straight = Equations(Chain(5.0)).boxed();
    let error = ImplicitMap::new(straight, about(&[None; LINKS], 2), 0.0, &[]);
    let error = error.err().unwrap();
    assert!(matches!(error, ImplicitError::Singular { .. }), "{error}");
}

const ROWS: usize = 22;
const COLUMNS: usize = ROWS + 1;

/// Kahan's matrix (1966), whose columns look ever less independent one after the other and are all but
/// dependent, with a last column that would mend this and looks smaller still. Its equations are mixed by
/// rotations until all have the same length, which changes no column's length.
fn kahan() -> Equations<Linear<COLUMNS, ROWS>> {
    let (c, s) = (0.6, 0.8_f64);
    let mut J = SMatrix::<f64, ROWS, COLUMNS>::from_fn(|i, j| {
        let entry = match j.cmp(&i) {
            _ if j == ROWS => 0.0,
            std::cmp::Ordering::Less => 0.0,
            std::cmp::Ordering::Equal => 1.0,
            std::cmp::Ordering::Greater => -c,
        };
        s.powi(i as i32) * entry * (1.0 - 1e-6 * j as f64)
    });
    J[(ROWS - 1, ROWS)] = 0.9 * s.powi(ROWS as i32 - 1);
    let mean = J.norm_squared() / ROWS as f64;
    for _ in 1..ROWS {
        let squares: Vec<f64> = J.row_iter().map(|r| r.norm_squared()).collect();
        let by = |a: &usize, b: &usize| squares[*a].total_cmp(&squares[*b]);
        let (i, j) = ((0..ROWS).max_by(by).unwrap(), (0..ROWS).min_by(by).unwrap());
        let (a, b) = (squares[i] - mean, squares[j] - mean);
        let d = J.row(i).dot(&J.row(j));
        // (a + 2 d τ + b τ²) = 0 for the tangent of the angle.
        let tau = (-d - (d * d - a * b).sqrt()) / b;
        let (cosine, sine) = (1.0 / tau.hypot(1.0), tau / tau.hypot(1.0));
        let (first, second) = (J.row(i).into_owned(), J.row(j).into_owned());
        J.set_row(i, &(first * cosine + second * sine));
        J.set_row(j, &(second * cosine - first * sine));
    }
    Equations(Linear(J))
}

#[test]
fn where_pivoting_finds_no_good_split_the_tangent_space_is_taken() {
    let mut map =
        ImplicitMap::new(kahan().boxed(), about(&[None; COLUMNS], ROWS), 0.0, &[]).unwrap();
    assert_eq!(map.freedoms(), 1);
    assert_eq!(map.independent(), None);
    let tangent = map.condition(0.0, &[0.0]);
    // The split that pivoting leads to, the last column, and the best one.
    let mut by = |k: usize| {
        assert!(map.switch(0.0, Some(&[k]), &mut [0.0], &mut [0.0], &mut []));
        map.condition(0.0, &[0.0])
    };
    assert!(by(ROWS) > 1e3 * tangent);
    assert!(by(0) < 1.001 * tangent);
}

/// The circle at an angle, its first coordinate preferred or not.
fn circle(angle: f64, preference: f64) -> ImplicitMap {
    let mut about = about(&[Some(angle.cos()), Some(angle.sin())], 1);
    about.unknowns[0].preference = preference;
    ImplicitMap::new(Equations(Circle).boxed(), about, 0.0, &[]).unwrap()
}

#[test]
fn preferred_coordinates_are_taken_up_to_a_condition_of_ten_for_each_unknown() {
    let mut taken = Vec::new();
    for k in 1..78 {
        let angle = 0.01 * f64::from(k);
        let mut plain = circle(angle, 0.0);
        assert_eq!(plain.independent(), Some(vec![1]), "at {angle}");
        assert!(plain.switch(0.0, Some(&[0]), &mut [0.0], &mut [0.0], &mut []));
        // And not where they would be changed at once.
        let good = plain.condition(0.0, &[0.0]) <= 20.0;
        let preferred = circle(angle, 1.0).independent() == Some(vec![0]);
        assert_eq!(preferred, good, "at {angle}");
        taken.push(preferred);
    }
    assert!(!taken[0] && taken[76], "{taken:?}");
}

#[test]
fn a_singular_split_is_refused_and_leaves_the_map_as_it_is() {
    // At (1, 0) the circle has no slope for its first coordinate.
    let mut map = circle(0.0, 0.0);
    assert!(!map.switch(0.0, Some(&[0]), &mut [0.0], &mut [0.0], &mut []));
    assert_eq!(map.independent(), Some(vec![1]));
    let [x, _] = tangent(&map, 0.0, &[0.6]);
    assert!((x[0] - 0.8).hypot(x[1] - 0.6) < 1e-12, "{x:?}");
}

#[test]
fn a_split_is_kept_until_its_condition_is_ten_for_each_unknown() {
    let mut map = circle(0.5, 1.0);
    let mut q = [0.0];
    for k in 1..500 {
        // Towards the position where the first coordinate has no slope.
        q[0] = (0.5 * (1.0 - 0.002 * f64::from(k))).cos() - 0.5_f64.cos();
        let condition = map.condition(0.0, &q);
        if map.reparametrize(0.0, &mut q, &mut [0.0], &mut []) {
            assert!((20.0..21.0).contains(&condition), "{condition}");
            assert_eq!(map.independent(), Some(vec![1]));
            return;
        }
        assert!(condition <= 20.0, "{condition}");
    }
    panic!("it is kept for ever");
}
