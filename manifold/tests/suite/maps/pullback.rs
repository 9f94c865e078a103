//! The pull-back of a nonlinear residual: residual and all three tangents by slope, in one formula.

#![allow(non_snake_case)]

use crate::support::{Offset, Revolute};
use nalgebra::{DMatrix, DVector, SVector, Vector3};
use pullback_conformance::{self as check, Forces, TestState};
use pullback_manifold::map::{Map, Parametrization};
use pullback_manifold::pullback::{self, Slot, Tangents};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::system::Weights;

const N: usize = 10;

/// r(x, ẋ, ẍ) of ten coordinates in which everything depends on everything.
fn residual(x: &DVector<f64>, v: &DVector<f64>, a: &DVector<f64>) -> DVector<f64> {
    let mut r = DVector::zeros(N);
    for i in 0..N {
        let (j, k) = ((i + 3) % N, (i + 7) % N);
        r[i] = (x[j] * x[i]).sin() + 0.3 * v[i] * v[j] * x[k] - (1.5 + x[k].cos()) * a[i]
            + 0.2 * a[j] * v[k];
    }
    r
}

/// K, C, M of the residual above.
fn tangents(x: &DVector<f64>, v: &DVector<f64>, a: &DVector<f64>) -> [DMatrix<f64>; 3] {
    let mut out = [(); 3].map(|()| DMatrix::zeros(N, N));
    let [K, C, M] = &mut out;
    for i in 0..N {
        let (j, k) = ((i + 3) % N, (i + 7) % N);
        let c = (x[j] * x[i]).cos();
        K[(i, j)] -= c * x[i];
        K[(i, i)] -= c * x[j];
        K[(i, k)] -= 0.3 * v[i] * v[j] + x[k].sin() * a[i];
        C[(i, i)] -= 0.3 * v[j] * x[k];
        C[(i, j)] -= 0.3 * v[i] * x[k];
        C[(i, k)] -= 0.2 * a[j];
        M[(i, i)] += 1.5 + x[k].cos();
        M[(i, j)] -= 0.2 * v[k];
    }
    out
}

/// One slot's map with its operators as slices.
struct Position {
    map: Option<Box<dyn Parametrization>>,
    n: usize,
    d: usize,
    x: [Vec<f64>; 3],
    B: [Vec<f64>; 3],
    K_sigma: Vec<f64>,
}

impl Position {
    fn new(map: Option<Box<dyn Parametrization>>, dim: usize) -> Self {
        let (d, n) = map.as_ref().map_or((dim, dim), |m| m.dims());
        Self {
            map,
            n,
            d,
            x: [(); 3].map(|()| vec![0.0; n]),
            B: [(); 3].map(|()| vec![0.0; n * d]),
            K_sigma: vec![0.0; d * d],
        }
    }

    fn kinematics(&mut self, t: f64, motion: [&[f64]; 3]) {
        let [x, x_dot, x_ddot] = self.x.each_mut().map(|x| &mut x[..]);
        let Some(map) = &mut self.map else {
            for (x, given) in [x, x_dot, x_ddot].into_iter().zip(motion) {
                x.copy_from_slice(given);
            }
            return;
        };
        let [B, B_dot, B_ddot] = self.B.each_mut().map(|B| &mut B[..]);
        map.evaluate(t, motion, &mut [[x, B], [x_dot, B_dot], [x_ddot, B_ddot]]);
    }

    fn slot(&self) -> Slot<'_> {
        Slot {
            n: self.n,
            d: self.d,
            B: self.map.as_ref().map(|_| self.B[0].as_slice()),
            B_dot: &self.B[1],
            B_ddot: &self.B[2],
            K_sigma: &self.K_sigma,
        }
    }
}

/// A driven joint: one coordinate and the time give one of the embedding space.
#[derive(Clone)]
struct Screw;

impl Map<1, 1> for Screw {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, 1>) -> SVector<S, 1> {
        SVector::<S, 1>::new((q[0] + t).sin() + q[0] * q[0] * t)
    }
}

fn positions() -> Vec<Position> {
    let revolute = Revolute {
        axis: Vector3::new(0.6, 0.8, 0.0),
    };
    // Free; a frame at an offset; driven: 3 + 6 + 1 = 10 coordinates from 4 + 6 + 1 = 11.
    vec![
        Position::new(Some(revolute.boxed()), 0),
        Position::new(Some(Offset([0.3, -0.4, 0.8]).boxed()), 0),
        Position::new(Some(Screw.boxed()), 0),
    ]
}

/// The pulled-back forces at (t, q, q̇, q̈); `combine` gives the tangent for some weights.
fn pulled(
    positions: &mut [Position],
    s: &TestState,
) -> (
    DVector<f64>,
    impl Fn(&[Position], Weights) -> DMatrix<f64> + use<>,
) {
    let mut first = 0;
    let (zero, d) = (DVector::zeros(s.x.len()), s.x.len());
    let (v, a) = if s.is_static() {
        (&zero, &zero)
    } else {
        (&s.v, &s.a)
    };
    for position in positions.iter_mut() {
        let range = first..first + position.d;
        let part = |x: &DVector<f64>| x.as_slice()[range.clone()].to_vec();
        position.kinematics(s.t, [&part(&s.x), &part(v), &part(a)]);
        first = range.end;
    }
    let embed = |k: usize| {
        let all: Vec<f64> = positions.iter().flat_map(|p| p.x[k].clone()).collect();
        DVector::from_vec(all)
    };
    let (x, x_dot, x_ddot) = (embed(0), embed(1), embed(2));
    let r = residual(&x, &x_dot, &x_ddot);
    let [K, C, M] = tangents(&x, &x_dot, &x_ddot);
    let (mut row, mut column) = (0, 0);
    for position in positions.iter_mut() {
        if let Some(map) = &mut position.map {
            let q = &s.x.as_slice()[column..column + position.d];
            let f = &r.as_slice()[row..row + position.n];
            map.geometric_stiffness(s.t, q, f, &mut position.K_sigma);
        }
        row += position.n;
        column += position.d;
    }
    let mut r_mr = DVector::zeros(d);
    let slots: Vec<Slot<'_>> = positions.iter().map(Position::slot).collect();
    pullback::residual(&slots, r.as_slice(), r_mr.as_mut_slice());
    let combine = move |positions: &[Position], weights: Weights| {
        let slots: Vec<Slot<'_>> = positions.iter().map(Position::slot).collect();
        let mut S = DMatrix::from_element(d, d, 1e3);
        let tangents = Tangents {
            K: Some(K.as_slice()),
            C: Some(C.as_slice()),
            M: Some(M.as_slice()),
        };
        pullback::tangent(
            &slots,
            tangents,
            weights,
            S.as_mut_slice(),
            &mut [f64::NAN; N],
        );
        S
    };
    (r_mr, combine)
}

const ONE: [Weights; 3] = [
    Weights::STATIC,
    Weights {
        K: 0.0,
        C: 1.0,
        M: 0.0,
    },
    Weights::MASS,
];

fn forces(positions: &mut [Position], s: &TestState) -> Forces {
    let (r, combine) = pulled(positions, s);
    Forces {
        r,
        K: combine(positions, ONE[0]),
        C: Some(combine(positions, ONE[1])),
        M: Some(combine(positions, ONE[2])),
        r_t: None,
        energy: None,
    }
}

#[test]
fn tangents_of_the_pulled_back_residual() {
    let mut positions = positions();
    let states: Vec<_> = check::states(11)
        .into_iter()
        // A revolute joint between rotations of 2π − 0.3 each is beyond 2π.
        .filter(|(at, _)| !at.starts_with("2pi"))
        .collect();
    check::forces_at(
        "pull-back",
        &check::Layout::plain(states[0].1.x.len()),
        &states,
        false,
        |s| Some(forces(&mut positions, s)),
    )
    .assert();
}

#[test]
fn weights_mix_linearly() {
    let mut positions = positions();
    let weights = Weights {
        K: 0.7,
        C: -1.3,
        M: 2.1,
    };
    for (at, state) in check::states(11) {
        let (_, combine) = pulled(&mut positions, &state);
        let [K, C, M] = ONE.map(|w| combine(&positions, w));
        let sum = K * weights.K + C * weights.C + M * weights.M;
        let gap = (combine(&positions, weights) - &sum).norm() / sum.norm();
        assert!(gap < 1e-13, "{at}: {gap:e}");
    }
}

#[test]
fn identity_slots_and_absent_tangents_cost_nothing_and_change_nothing() {
    // A slot without a map is the identity, wherever it stands among the others.
    let (x, v, a) = (
        DVector::from_fn(N, |i, _| 0.1 * i as f64 - 0.3),
        DVector::from_fn(N, |i, _| (i as f64).sin()),
        DVector::from_fn(N, |i, _| (i as f64).cos()),
    );
    let [K, C, M] = tangents(&x, &v, &a);
    let mut positions = vec![
        Position::new(None, 3),
        Position::new(Some(Offset([0.3, -0.4, 0.8]).boxed()), 0),
        Position::new(None, 1),
    ];
    let state = TestState {
        t: 0.0,
        x: x.clone(),
        v,
        a,
    };
    let (r, combine) = pulled(&mut positions, &state);
    assert_eq!(r.len(), 10);
    // Dense: B = diag(I, B, I).
    let mut B = DMatrix::<f64>::identity(N, N);
    B.view_mut((3, 3), (6, 6))
        .copy_from_slice(&positions[1].B[0]);
    let M_mr = combine(&positions, Weights::MASS);
    // M at the embedded x, not at q.
    let embedded = |k: usize| {
        DVector::from_vec(
            positions
                .iter()
                .flat_map(|p| p.x[k].clone())
                .collect::<Vec<_>>(),
        )
    };
    let [.., M_x] = tangents(&embedded(0), &embedded(1), &embedded(2));
    assert!((M_mr - B.transpose() * M_x * B).norm() < 1e-13);
    // Slots that are all the identity return the weighted sum, also without C or M.
    let slots = [Slot {
        n: N,
        d: N,
        ..Slot::default()
    }];
    let weights = Weights {
        K: 2.0,
        C: 3.0,
        M: 5.0,
    };
    for (with_C, with_M) in [(true, true), (false, true), (true, false), (false, false)] {
        let mut S = DMatrix::zeros(N, N);
        let tangents = Tangents {
            K: Some(K.as_slice()),
            C: with_C.then_some(C.as_slice()),
            M: with_M.then_some(M.as_slice()),
        };
        pullback::tangent(&slots, tangents, weights, S.as_mut_slice(), &mut [0.0; N]);
        let mut expected = &K * 2.0;
        if with_C {
            expected += &C * 3.0;
        }
        if with_M {
            expected += &M * 5.0;
        }
        assert!((S - expected).norm() < 1e-13);
    }
}

#[test]
fn a_slot_whose_geometric_stiffness_is_added_elsewhere_may_leave_it_empty() {
    let mut positions = positions();
    let (_, state) = check::states(11).swap_remove(5);
    let (_, combine) = pulled(&mut positions, &state);
    let whole = combine(&positions, Weights::STATIC);
    let mut missing = DMatrix::zeros(11, 11);
    let mut first = 0;
    for position in &mut positions {
        missing
            .view_mut((first, first), (position.d, position.d))
            .copy_from_slice(&position.K_sigma);
        position.K_sigma.clear();
        first += position.d;
    }
    let without = combine(&positions, Weights::STATIC);
    assert!(missing.norm() > 0.1);
    assert!((whole + missing - without).norm() < 1e-13);
}
