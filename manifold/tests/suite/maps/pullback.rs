//! The pull-back of a nonlinear residual: residual and all three tangents by slope, in one formula.

#![allow(non_snake_case)]

use crate::support::Offset;
use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, SVector};
use pullback_conformance::{self as check, Forces, Random, TestState};
use pullback_manifold::map::Map;
use pullback_manifold::pullback;
use pullback_manifold::scalar::Scalar;

const N: usize = 10;
/// Time of the states.
const T: f64 = 0.37;

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

/// A driven joint: one coordinate and the time give one of the embedding space.
#[derive(Clone)]
struct Screw;

impl Map<1, 1> for Screw {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, 1>) -> SVector<S, 1> {
        SVector::<S, 1>::new((q[0] + t).sin() + q[0] * q[0] * t)
    }
}

/// A map of the coordinates from `first` on.
struct Behind<'a, const D: usize, M> {
    map: &'a M,
    first: usize,
    q: SVector<f64, D>,
    B: [SMatrix<f64, D, D>; 3],
}

impl<'a, const D: usize, M: Map<D, D>> Behind<'a, D, M> {
    /// The map at a motion, which is that of its values afterwards.
    fn new(map: &'a M, first: usize, motion: &mut [DVector<f64>; 3]) -> Self {
        let own = |x: &DVector<f64>| SVector::from_column_slice(&x.as_slice()[first..first + D]);
        let [q, v, a] = motion.each_ref().map(own);
        let k = map.kinematics(T, &q, &v, &a);
        for (x, value) in motion.iter_mut().zip([k.x, k.x_dot, k.x_ddot]) {
            x.rows_mut(first, D).copy_from(&value);
        }
        let B = [k.B, k.B_dot, k.B_ddot];
        Self { map, first, q, B }
    }

    fn pull_back(&self, r: &mut DVector<f64>, parts: &mut [&mut [f64]]) {
        let f = SVector::<f64, D>::from_column_slice(&r.as_slice()[self.first..self.first + D]);
        let K_sigma = self.map.geometric_stiffness(T, &self.q, &f);
        pullback::tangents(parts, N, self.first, &self.B, &K_sigma);
        r.rows_mut(self.first, D).copy_from(&self.B[0].tr_mul(&f));
    }
}

/// The forces at (q, q̇, q̈): three coordinates of their own, a frame at an offset and a driven one behind maps.
fn forces(s: &TestState) -> Forces {
    let zero = DVector::zeros(N);
    let moving = |x: &DVector<f64>| {
        if s.is_static() {
            zero.clone()
        } else {
            x.clone()
        }
    };
    let mut motion = [s.x.clone(), moving(&s.v), moving(&s.a)];
    let offset = Offset([0.3, -0.4, 0.8]);
    let frame = Behind::new(&offset, 3, &mut motion);
    let driven = Behind::new(&Screw, 9, &mut motion);
    let [x, v, a] = &motion;
    let mut r = residual(x, v, a);
    let mut parts = tangents(x, v, a);
    let mut slices = parts.each_mut().map(|part| part.as_mut_slice());
    frame.pull_back(&mut r, &mut slices);
    driven.pull_back(&mut r, &mut slices);
    let [K, C, M] = parts;
    let (C, M, r_t, energy) = (Some(C), Some(M), None, None);
    Forces {
        r,
        K,
        C,
        M,
        r_t,
        energy,
    }
}

#[test]
fn tangents_of_the_pulled_back_residual() {
    let layout = check::Layout::plain(N);
    let states = check::states(N);
    check::forces_at("pull-back", &layout, &states, false, |s| Some(forces(s))).assert();
}

/// Bᵀ (K B + C Ḃ + M B̈) − K_σ and so on, with B, Ḃ and B̈ of all coordinates as whole matrices.
#[test]
fn the_pull_back_in_place_is_that_of_whole_matrices() {
    let mut random = Random::default();
    let mut matrix = || DMatrix::from_fn(N, N, |_, _| random.range(-1.0, 1.0));
    let (given, [B, B_dot, B_ddot, own]) = ([(); 3].map(|()| matrix()), [(); 4].map(|()| matrix()));
    let block = |B: &DMatrix<f64>| Matrix3::from(B.fixed_view::<3, 3>(4, 4));
    let whole = |B: &DMatrix<f64>, outside: DMatrix<f64>| {
        let mut all = outside;
        all.fixed_view_mut::<3, 3>(4, 4).copy_from(&block(B));
        all
    };
    let (one, none) = (DMatrix::identity(N, N), DMatrix::zeros(N, N));
    let [Z, Z_dot, Z_ddot] = [(&B, one), (&B_dot, none.clone()), (&B_ddot, none.clone())]
        .map(|(B, outside)| whole(B, outside));
    let K_sigma = whole(&own, none);
    let [K, C, M] = &given;
    let exact = [
        Z.transpose() * (K * &Z + C * &Z_dot + M * &Z_ddot) - &K_sigma,
        Z.transpose() * (C * &Z + M * &Z_dot * 2.0),
        Z.transpose() * M * &Z,
    ];
    let operators = [&B, &B_dot, &B_ddot].map(block);
    let mut found = given.clone();
    let mut slices = found.each_mut().map(|part| part.as_mut_slice());
    pullback::tangents(&mut slices, N, 4, &operators, &block(&own));
    for (found, exact) in found.iter().zip(&exact) {
        assert!((found - exact).amax() < 1e-14);
    }
    let mut K = K.clone();
    pullback::tangents(&mut [K.as_mut_slice()], N, 4, &operators, &block(&own));
    let at_rest = Z.transpose() * &given[0] * &Z - K_sigma;
    assert!((K - at_rest).amax() < 1e-14);
}
