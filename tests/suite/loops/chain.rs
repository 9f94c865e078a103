//! Chains with several freedoms and with more equations than needed, closed by h(t, x) = 0, against
//! multipliers and a pendulum.

#![allow(non_snake_case, clippy::unwrap_used)]

use crate::support::dynamics::*;
use crate::support::loops::*;
use nalgebra::{SMatrix, SVector, Vector2};
use pullback::conformance as check;
use pullback::elements::model::{Context, ModelBuilder, NodeId};
use pullback::manifold::implicit::{Choice, Implicit, ImplicitMap};
use pullback::manifold::map::{Linear, Map, Parametrization};
use pullback::manifold::scalar::Scalar;
use pullback::manifold::system::Quantity;

// A chain of five bars -------------------------------------------------------------------------

const LINKS: usize = 5;
const SPAN: f64 = 3.0;

/// A chain of bars of length and mass one between two points of the ceiling.
#[derive(Clone, Copy, Debug)]
struct Chain;

impl Implicit<LINKS, 2> for Chain {
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, LINKS>) -> SVector<S, 2> {
        let mut end = Vector2::new(S::constant(-SPAN), S::zero());
        for x in x.iter() {
            end[0] += x.cos();
            end[1] += x.sin();
        }
        end
    }
}

/// Angles and rates by multipliers: M ẍ + Jᵀλ = f, J ẍ = −J̇ ẋ.
fn chain_exact(from: &SVector<f64, LINKS>, v: &SVector<f64, LINKS>, to: f64) -> Vec<f64> {
    const N: usize = LINKS;
    let weight = |i: usize, k: usize| match k.cmp(&i) {
        std::cmp::Ordering::Less => 1.0,
        std::cmp::Ordering::Equal => 0.5,
        std::cmp::Ordering::Greater => 0.0,
    };
    let ode = |_: f64, z: &SVector<f64, 10>| {
        let mut A = SMatrix::<f64, 7, 7>::zeros();
        let mut b = SVector::<f64, 7>::zeros();
        for k in 0..N {
            for j in 0..N {
                let w: f64 = (0..N).map(|i| weight(i, k) * weight(i, j)).sum();
                A[(k, j)] = w * (z[k] - z[j]).cos();
                b[k] -= w * (z[k] - z[j]).sin() * z[N + j].powi(2);
            }
            A[(k, k)] += 1.0 / 12.0;
            b[k] -= G * z[k].cos() * (0..N).map(|i| weight(i, k)).sum::<f64>();
            for (row, d) in [(N, -z[k].sin()), (N + 1, z[k].cos())] {
                A[(row, k)] = d;
                A[(k, row)] = d;
            }
            b[N] += z[k].cos() * z[N + k].powi(2);
            b[N + 1] += z[k].sin() * z[N + k].powi(2);
        }
        let solution = A.lu().solve(&b).unwrap();
        SVector::<f64, 10>::from_fn(|k, _| if k < N { z[N + k] } else { solution[k - N] })
    };
    let start = SVector::<f64, 10>::from_fn(|k, _| if k < N { from[k] } else { v[k - N] });
    let z = integrate_ode(&ode, start, to, 20_000);
    z.as_slice().to_vec()
}

#[test]
fn a_chain_of_bars_closes() {
    let to = 2.0;
    let guess = [-1.2, -0.6, 0.3, 0.5, 1.0];
    for choice in [Choice::Split, Choice::Tangent] {
        let mut map = ImplicitMap::of(Chain, 3, 0.0, guess, choice).unwrap();
        check::implicit(&map, 0.0).assert();
        let (mut x, mut B) = ([0.0; LINKS], [0.0; 3 * LINKS]);
        map.evaluate(0.0, [&[0.0; 3], &[], &[]], &mut [[&mut x, &mut B]]);
        let v = SVector::<f64, 3>::new(1.0, -2.0, 1.5);
        let x_dot = SMatrix::<f64, LINKS, 3>::from_column_slice(&B) * v;
        let exact = chain_exact(&x.into(), &x_dot, to);
        let errors = [1000, 2000, 4000].map(|n| {
            let (mut b, ground) = grounded();
            let q = b.coordinates("q", &[Quantity::Angle; 3]).unwrap();
            let x = b
                .mapped_coordinates("x", &[Quantity::Angle; 5], Box::new(map.clone()), &[q])
                .unwrap();
            let mut frame = ground;
            for k in 0..LINKS {
                let mut factors = [0.0; LINKS];
                factors[k] = 1.0;
                if k > 0 {
                    factors[k - 1] = -1.0;
                }
                let turn = Linear::sum(factors, 0.0).boxed();
                let turn =
                    b.mapped_coordinates(format!("turn {k}"), &[Quantity::Angle], turn, &[x]);
                frame = bar(&mut b, frame, [k as f64, 0.0, 0.0], turn.unwrap(), 1.0, 1.0);
            }
            let h = |x: &SVector<f64, LINKS>| Chain.h(0.0, x).amax();
            let context = Context::new(b.build().unwrap());
            let run = run(context, x, v.as_slice(), &h, [to, to / f64::from(n)]);
            let changes = run.progress.summary.chart_changes;
            assert!(changes > 0 || choice == Choice::Tangent, "{:?}", run.notes);
            assert!(run.residual < 1e-14, "{:e}", run.residual);
            vec![gap(&run.end, &exact), run.drift]
        });
        assert_slopes("chain", &["motion", "energy"], &errors, 2.0, 0.25);
    }
}

// Redundant equations --------------------------------------------------------------------------

/// A plate on three parallel cranks of the same length: the third one only fits. `length` is that
/// of the third crank.
#[derive(Clone, Copy, Debug)]
struct Parallelogram {
    length: f64,
}

impl Implicit<4, 4> for Parallelogram {
    /// x: angles of the three cranks and of the plate.
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, 4>) -> SVector<S, 4> {
        let pin = |k: usize, l: f64, at: f64| {
            [
                x[0].cos() + x[3].cos() * at - x[k].cos() * l - at,
                x[0].sin() + x[3].sin() * at - x[k].sin() * l,
            ]
        };
        let ([a, b], [c, d]) = (pin(1, 1.0, 2.0), pin(2, self.length, 1.0));
        SVector::<S, 4>::new(a, b, c, d)
    }

    fn equation(&self, i: usize) -> String {
        [
            "second pin, e1",
            "second pin, e2",
            "third pin, e1",
            "third pin, e2",
        ][i]
            .to_owned()
    }
}

/// The plate on its cranks, under their weights.
fn carried(map: ImplicitMap) -> (ModelBuilder, NodeId) {
    let (mut b, ground) = grounded();
    let q = b.coordinates("q", &[Quantity::Angle]).unwrap();
    let x = b
        .mapped_coordinates("x", &[Quantity::Angle; 4], Box::new(map), &[q])
        .unwrap();
    let cranks = [0, 1, 2].map(|k| pick::<4>(&mut b, x, k, Quantity::Angle));
    let first = bar(&mut b, ground, [0.0; 3], cranks[0], 1.0, 1.0);
    bar(&mut b, ground, [2.0, 0.0, 0.0], cranks[1], 1.0, 2.0);
    bar(&mut b, ground, [1.0, 0.0, 0.0], cranks[2], 1.0, 3.0);
    let turn = Linear::sum([-1.0, 0.0, 0.0, 1.0], 0.0).boxed();
    let turn = b
        .mapped_coordinates("turn", &[Quantity::Angle], turn, &[x])
        .unwrap();
    bar(&mut b, first, [1.0, 0.0, 0.0], turn, 2.0, 4.0);
    (b, x)
}

/// Angle and rate of the cranks at a time: as the plate only translates, a pendulum,
/// (Σ m/3 + m_p) θ̈ = −g (Σ m/2 + m_p) cos θ.
fn pendulum(start: Vector2<f64>, to: f64) -> Vector2<f64> {
    let ode = |_: f64, z: &Vector2<f64>| Vector2::new(z[1], -G * z[0].cos() * 7.0 / 6.0);
    integrate_ode(&ode, start, to, 4000)
}

#[test]
fn a_redundant_crank_is_named_and_carried_along() {
    let start = -1.0_f64;
    let guess = [start, start, start, 0.0];
    let plate = |length| {
        let cranks = Parallelogram { length };
        ImplicitMap::of(cranks, 1, 0.0, guess, Choice::Split)
    };
    let map = plate(1.0).unwrap();
    assert_eq!(map.redundant().len(), 1, "{:?}", map.redundant());
    let error = plate(0.95).err().unwrap();
    assert!(error.to_string().contains("pin"), "{error}");
    let (b, x) = carried(map);
    let to = 1.0;
    let z = pendulum(Vector2::new(start, 0.0), to);
    let exact = [z[0], z[0], z[0], 0.0, z[1], z[1], z[1], 0.0];
    let h = |x: &SVector<f64, 4>| Parallelogram { length: 1.0 }.h(0.0, x).amax();
    let run = run(Context::new(b.build().unwrap()), x, &[0.0], &h, [to, 1e-3]);
    assert!(gap(&run.end, &exact) < 1e-4, "{:?}", run.end);
    assert!(run.residual < 1e-14);
    assert!(run.notes[0].1.contains("redundant: "), "{:?}", run.notes);
}
