//! Multi-blade coordinates: a rotor seen from the frame that does not rotate.
//!
//! Beside parts that do not rotate, the linear equations of a rotor have periodic coefficients in its own coordinates q. Let P
//! turn a pattern of motion by α = 2π/N, as from each of N blades to the next one, P^N = 1. With
//!
//! ```text
//! q = T(ψ) z,     T(ψ) = P^(−ψ/α) = (1/N) Σ_j Σ_k cos k(ψ + jα) P^j,     j = 0 … N − 1,  |k| < N/2
//! ```
//!
//! patterns that stand still in space have constant z. Those that change sign from blade to blade do not move the other parts,
//! and do not turn: an even N has them in the further terms (−1)^j P^j / N. For N ≥ 3 the coefficients of z are constant
//! (Coleman & Feingold 1958, NACA report 1351). As T(ψ) is a power, T' = T G with G = T'(0), so that with ψ̇ = Ω
//!
//! ```text
//! q̇ = T (d/dt + ΩG) z,     q̈ = T (d/dt + ΩG)² z
//! ```
//!
//! and the coefficients are those at angle zero, where T = 1: M, C + 2ΩMG and K + ΩCG + Ω²MG².

use super::{Linearized, Mode};
use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut};
use num_complex::Complex64;
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::CyclicSymmetry;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Blocks of one row, by column.
type Row<T> = BTreeMap<usize, T>;

/// Factors of P^j in T, T' and T''.
fn factors(order: usize, j: usize, angle: f64) -> [f64; 3] {
    let n = order as f64;
    let alternating = match (order % 2, j % 2) {
        (0, 0) => 1.0,
        (0, _) => -1.0,
        _ => 0.0,
    };
    let mut sums = [1.0 + alternating, 0.0, 0.0];
    for k in (1..order.div_ceil(2)).map(|k| k as f64) {
        let (sin, cos) = (k * (angle + j as f64 * TAU / n)).sin_cos();
        sums[0] += 2.0 * cos;
        sums[1] -= 2.0 * k * sin;
        sums[2] -= 2.0 * k * k * cos;
    }
    sums.map(|sum| sum / n)
}

/// P x, or Pᵀ x, where what does not rotate stays as it is.
fn turned(rotor: &CyclicSymmetry, x: &[Complex64], transposed: bool) -> Vec<Complex64> {
    let mut y = x.to_vec();
    for &(r, ..) in &rotor.turn {
        y[r] = Complex64::ZERO;
    }
    for &(r, c, p) in &rotor.turn {
        let (r, c) = if transposed { (c, r) } else { (r, c) };
        y[r] += p * x[c];
    }
    y
}

/// Angle at which equations are compared with those at angle zero.
pub(super) const TURN: f64 = 1.0;

/// T x, T' x and T'' x at the angle [`TURN`], or those of the transposed matrices; T = 1 without a rotor.
fn transformed(
    rotor: Option<&CyclicSymmetry>,
    x: &[Complex64],
    transposed: bool,
) -> [Vec<Complex64>; 3] {
    let mut sums = [(); 3].map(|()| vec![Complex64::ZERO; x.len()]);
    let mut power = x.to_vec();
    let Some(rotor) = rotor else {
        sums[0] = power;
        return sums;
    };
    for j in 0..rotor.order {
        for (sum, factor) in sums.iter_mut().zip(factors(rotor.order, j, TURN)) {
            let terms = sum.iter_mut().zip(&power);
            terms.for_each(|(sum, x)| *sum += factor * x);
        }
        power = turned(rotor, &power, transposed);
    }
    sums
}

/// The rotor's own q, q̇ and q̈ after the turn where multi-blade coordinates move in a mode: (λ + Ω d/dψ)^k T φ.
pub(super) fn motion(
    rotor: Option<&CyclicSymmetry>,
    mode: &Mode,
    speed: f64,
) -> [Vec<Complex64>; 3] {
    let [q, q1, q2] = transformed(rotor, &mode.shape, false);
    let rate = |x: &[Complex64], x1: &[Complex64]| -> Vec<Complex64> {
        let terms = x.iter().zip(x1);
        terms
            .map(|(x, x1)| mode.eigenvalue * x + speed * x1)
            .collect()
    };
    let v = rate(&q, &q1);
    let a = rate(&v, &rate(&q1, &q2));
    [q, v, a]
}

/// Forces at the rotor's own coordinates after the turn, at multi-blade ones: Tᵀ f.
pub(super) fn pulled_back(rotor: Option<&CyclicSymmetry>, f: &[Complex64]) -> Vec<Complex64> {
    let [f, ..] = transformed(rotor, f, true);
    f
}

/// P of what rotates, row by row.
fn turn(rotor: &CyclicSymmetry, pattern: &BlockPattern) -> Vec<Row<DMatrix<f64>>> {
    let blocks = 0..pattern.blocks();
    let of_unknown = blocks.flat_map(|i| pattern.unknowns(i).map(move |u| (i, u)));
    let of_unknown: Vec<_> = of_unknown
        .map(|(i, u)| (i, u - pattern.unknowns(i).start))
        .collect();
    let mut turn = vec![Row::new(); pattern.blocks()];
    for &(r, c, x) in &rotor.turn {
        let ((i, r), (j, c)) = (of_unknown[r], of_unknown[c]);
        let zeros = || DMatrix::zeros(pattern.size(i), pattern.size(j));
        turn[i].entry(j).or_insert_with(zeros)[(r, c)] = x;
    }
    turn
}

/// G and G² = T''(0), row by row.
fn generator(rotor: &CyclicSymmetry, pattern: &BlockPattern) -> Vec<Row<[DMatrix<f64>; 2]>> {
    let turn = turn(rotor, pattern);
    let row = |i: usize| {
        let mut row: Row<[DMatrix<f64>; 2]> = Row::new();
        if turn[i].is_empty() {
            return row;
        }
        let one = DMatrix::identity(pattern.size(i), pattern.size(i));
        let mut power = Row::from([(i, one)]);
        for [_, first, second] in (0..rotor.order).map(|j| factors(rotor.order, j, 0.0)) {
            let mut next = Row::new();
            for (j, X) in power {
                for (k, P) in &turn[j] {
                    let product = &X * P;
                    *next.entry(*k).or_insert_with(|| product.map(|_| 0.0)) += product;
                }
                let zeros = || [0, 1].map(|_| X.map(|_| 0.0));
                let [G, GG] = row.entry(j).or_insert_with(zeros);
                *G += first * &X;
                *GG += second * &X;
            }
            power = next;
        }
        row
    };
    (0..pattern.blocks()).map(row).collect()
}

impl Linearized {
    /// The equations at angle zero in multi-blade coordinates, which are the rotor's own there.
    pub(super) fn in_multi_blade_coordinates(self, rotor: &CyclicSymmetry, speed: f64) -> Self {
        let old = &self.pattern;
        let G = generator(rotor, old);
        let pairs = || (0..old.blocks()).flat_map(|j| old.column(j).map(move |(i, at)| (i, j, at)));
        let groups = pairs().filter(|(i, j, _)| i >= j).map(|(i, j, _)| {
            let turned = G[i].keys().chain(G[j].keys()).copied();
            let blocks = turned.chain([i, j]);
            blocks.map(|block| block as u32).collect::<Vec<_>>()
        });
        let sizes: Vec<usize> = (0..old.blocks()).map(|block| old.size(block)).collect();
        let pattern = BlockPattern::new(&sizes, groups);
        let pattern = pattern.with_coordinates(|u| old.coordinates()[u]);
        let mut matrices = [(); 3].map(|()| vec![0.0; pattern.len()]);
        for (i, j, at) in pairs() {
            let own = [&self.K, &self.C, &self.M].map(|values| &values[at.clone()]);
            let mut add = |to: usize, b: usize, factor: f64, X: &[f64], Y: &DMatrix<f64>| {
                if let Some(first) = pattern.find(i, b) {
                    let values = &mut matrices[to][first..first + sizes[i] * sizes[b]];
                    let X = DMatrixView::from_slice(X, sizes[i], sizes[j]);
                    DMatrixViewMut::from_slice(values, sizes[i], sizes[b]).gemm(factor, &X, Y, 1.0);
                }
            };
            let [_, C, M] = own;
            let one = DMatrix::identity(sizes[j], sizes[j]);
            own.iter()
                .enumerate()
                .for_each(|(to, X)| add(to, j, 1.0, X, &one));
            for (&b, [G, GG]) in &G[j] {
                add(1, b, 2.0 * speed, M, G);
                add(0, b, speed, C, G);
                add(0, b, speed * speed, M, GG);
            }
        }
        let [K, C, M] = matrices;
        Self {
            pattern,
            K,
            C,
            M,
            ..self
        }
    }
}
