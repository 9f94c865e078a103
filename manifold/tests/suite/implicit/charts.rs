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

fn about(starts: &[Option<f64>], equations: usize) -> Description {
    let unknown = |(k, start): (usize, &Option<f64>)| Unknown {
        name: format!("x{k}"),
        size: 1.0,
        start: *start,
        preference: 0.0,
    };
    Description {
        unknowns: starts.iter().enumerate().map(unknown).collect(),
        equations: (0..equations)
            .map(|i| Equation {
                name: format!("h{i}"),
                size: Some(1.0),
            })
            .collect(),
        good_condition: 10.0,
        ..Description::default()
    }
}

/// x, ẋ, ẍ, B, Ḃ, B̈ and K_σ(f).
fn everything(
    map: &dyn Parametrization,
    q: &[f64],
    v: &[f64],
    a: &[f64],
    f: &[f64],
) -> Vec<Vec<f64>> {
    let mut out = motion(map, T, [q, v, a]).to_vec();
    let mut K = vec![0.0; q.len() * q.len()];
    map.duplicate().geometric_stiffness(T, q, f, &mut K);
    out.push(K);
    out
}

fn difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    assert_eq!(a.len(), b.len());
    let gap = |(a, b): (&Vec<f64>, &Vec<f64>)| {
        assert_eq!(a.len(), b.len());
        let size = b.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
        a.iter()
            .zip(b)
            .fold(0.0_f64, |m, (a, b)| m.max((a - b).abs() / size))
    };
    a.iter().zip(b).map(gap).fold(0.0, f64::max)
}

/// The chain where the angles of its first three bars are given: the others make a triangle.
#[derive(Clone, Copy)]
struct Triangle;

impl Map<3, LINKS> for Triangle {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, 3>) -> SVector<S, LINKS> {
        let x = [0, 1, 2].map(|k| q[k] + GUESS[k]);
        let mut rest = Vector2::new(t * t * 0.1 + 3.0, -t * 0.2);
        for x in x {
            rest[0] -= x.cos();
            rest[1] -= x.sin();
        }
        let half = rest.dot(&rest) * 0.25;
        let angle = (-half + 1.0).sqrt().atan2(half.sqrt());
        let between = rest[1].atan2(rest[0]);
        SVector::from([x[0], x[1], x[2], between - angle, between + angle])
    }
}

fn start() -> [f64; LINKS] {
    Triangle.phi(T, &SVector::zeros()).into()
}

#[test]
fn derivatives_are_those_of_a_closed_form_with_redundant_equations() {
    let starts = start().map(Some);
    let mut map = ImplicitMap::new(Twice.boxed(), about(starts.as_slice(), 4), T, &[]).unwrap();
    assert_eq!(map.freedoms(), 3);
    let said = map.describe();
    assert!(said.contains("redundant: "), "{said}");
    let (mut q, mut v) = ([0.0; 3], [0.0; 3]);
    assert!(map.switch(T, Some(&[0, 1, 2]), &mut q, &mut v, &mut []));
    let [v, a] = [[0.4, -0.7, 1.1], [0.3, 0.9, -0.2]];
    let f = [0.2, -0.5, 1.0, 0.7, -0.3];
    for reach in [0.0, 1e-8, 0.1, 0.3] {
        let q = [reach, -0.5 * reach, 0.8 * reach];
        let one = everything(&map, &q, &v, &a, &f);
        let other = everything(&*Triangle.boxed(), &q, &v, &a, &f);
        let gap = difference(&one, &other);
        assert!(gap < 1e-11, "at {reach}: {gap:e}");
    }
}

#[test]
fn parameters_are_independent_coordinates_from_outside() {
    // The first bar is given: (p, x) as one vector.
    let x = start();
    let starts: Vec<Option<f64>> = x.iter().skip(1).copied().map(Some).collect();
    let mut map = ImplicitMap::new(CHAIN.boxed(), about(&starts, 2), T, &[x[0]]).unwrap();
    assert_eq!(map.freedoms(), 2);
    let (mut q, mut v) = ([0.0, 0.0, x[0]], [0.0; 3]);
    assert!(map.switch(T, Some(&[0, 1]), &mut q, &mut v, &mut []));
    let f = [0.2, -0.5, 1.0, 0.7];
    for reach in [0.0, 0.1, 0.3] {
        // Order of the fixed one: x0, x1, x2; of the other: x1, x2, p = x0.
        let turn = |z: [f64; 3]| [z[1], z[2], z[0]];
        let (q, v, a) = (
            [reach, -0.5 * reach, 0.8 * reach],
            [0.4, -0.7, 1.1],
            [0.3, 0.9, -0.2],
        );
        let mut at = turn(q);
        at[2] += x[0];
        let one = everything(&map, &at, &turn(v), &turn(a), &f);
        let f = [0.0, f[0], f[1], f[2], f[3]];
        let other = everything(&*Triangle.boxed(), &q, &v, &a, &f);
        let columns = [1, 2, 0];
        let other: Vec<Vec<f64>> = (other.iter().enumerate())
            .map(|(k, z)| match k {
                0..3 => z[1..].to_vec(),
                3..6 => (columns.iter())
                    .flat_map(|&j| z[j * LINKS + 1..(j + 1) * LINKS].to_vec())
                    .collect(),
                _ => (columns.iter())
                    .flat_map(|&j| columns.map(|i| z[i + 3 * j]))
                    .collect(),
            })
            .collect();
        let gap = difference(&one, &other);
        assert!(gap < 1e-11, "at {reach}: {gap:e}");
    }
}

#[test]
fn a_change_of_chart_keeps_the_motion_and_can_be_recalled() {
    let starts = start().map(Some);
    let mut map = ImplicitMap::new(Twice.boxed(), about(starts.as_slice(), 4), T, &[]).unwrap();
    let f = [0.0; LINKS];
    let (mut q, mut v) = ([0.1, -0.2, 0.15], [0.4, -0.7, 1.1]);
    let mut a = vec![vec![0.3, 0.9, -0.2], vec![-1.0, 0.1, 0.5]];
    for independent in [Some([0, 2, 4]), None, Some([1, 2, 3])] {
        let before = [0, 1].map(|k| everything(&map, &q, &v, &a[k], &f)[..3].to_vec());
        let chosen = independent.as_ref().map(|k| &k[..]);
        assert!(map.switch(T, chosen, &mut q, &mut v, &mut a));
        for k in 0..2 {
            let after = everything(&map, &q, &v, &a[k], &f)[..3].to_vec();
            let gap = difference(&after, &before[k]);
            assert!(gap < 1e-13, "{independent:?}: {gap:e}");
        }
    }
    // A fresh one that recalls what this one remembers is the same to the last bit.
    let mut fresh = ImplicitMap::new(Twice.boxed(), about(starts.as_slice(), 4), T, &[]).unwrap();
    assert!(!fresh.restore(&map.save()[1..]));
    assert!(fresh.restore(&map.save()));
    let next = [q[0] + 0.02, q[1], q[2] - 0.01];
    let [one, other] = [&map, &fresh].map(|map| everything(map, &next, &v, &a[0], &f));
    assert_eq!(one, other);
}

#[test]
fn what_does_not_close_is_named() {
    // Five bars of length one do not reach 3 + 0.1 t² for t = 6.
    let error = ImplicitMap::new(Twice.boxed(), about(&[None; LINKS], 4), 6.0, &[]);
    let error = error.err().unwrap();
    assert!(error.to_string().contains('h'), "{error}");
    let ImplicitError::NotAssembled { .. } = error else {
        panic!("{error}");
    };
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
fn preferred_coordinates_are_taken_up_to_ten_times_the_best_condition() {
    let mut taken = Vec::new();
    for k in 1..78 {
        let angle = 0.01 * f64::from(k);
        let mut plain = circle(angle, 0.0);
        let best = plain.condition(0.0, &[0.0]);
        assert_eq!(plain.independent(), Some(vec![1]), "at {angle}");
        assert!(plain.switch(0.0, Some(&[0]), &mut [0.0], &mut [0.0], &mut []));
        // And not where they would be changed at once.
        let good = plain.condition(0.0, &[0.0]) <= (10.0 * best).min(20.0);
        let preferred = circle(angle, 1.0).independent() == Some(vec![0]);
        assert_eq!(preferred, good, "at {angle}");
        taken.push(preferred);
    }
    assert!(!taken[0] && taken[76], "{taken:?}");
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
