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
//! (Coleman & Feingold 1958, NACA report 1351): with ψ̇ = Ω they are
//!
//! ```text
//! TᵀMT,     Tᵀ(CT + 2ΩMT'),     Tᵀ(KT + ΩCT' + Ω²MT'')
//! ```

use super::Linearized;
use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut, DVectorView, DVectorViewMut};
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::CyclicSymmetry;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Blocks of one row, by column.
type Row<T> = BTreeMap<usize, T>;

/// Factors that count as rounding errors.
const NOTHING: f64 = 1e-14;

/// Factor of P^j in T, T' and T''.
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

/// P, row by row.
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

/// T, T' and T'' at an angle, row by row.
fn transformation(
    rotor: &CyclicSymmetry,
    pattern: &BlockPattern,
    angle: f64,
) -> Vec<Row<[DMatrix<f64>; 3]>> {
    let turn = turn(rotor, pattern);
    let factors: Vec<[f64; 3]> = (0..rotor.order)
        .map(|j| factors(rotor.order, j, angle))
        .collect();
    let row = |i: usize| {
        let n = pattern.size(i);
        let (one, zero) = (DMatrix::identity(n, n), DMatrix::zeros(n, n));
        if turn[i].is_empty() {
            return Row::from([(i, [one, zero.clone(), zero])]);
        }
        let mut row: Row<[DMatrix<f64>; 3]> = Row::new();
        let mut power = Row::from([(i, one)]);
        for factors in &factors {
            let mut next = Row::new();
            for (j, X) in power {
                for (k, P) in &turn[j] {
                    let product = &X * P;
                    let sum = next.entry(*k).or_insert_with(|| product.map(|_| 0.0));
                    *sum += product;
                }
                let row = row
                    .entry(j)
                    .or_insert_with(|| [0, 1, 2].map(|_| X.map(|_| 0.0)));
                for (sum, factor) in row.iter_mut().zip(factors) {
                    *sum += &X * *factor;
                }
            }
            power = next;
        }
        row
    };
    (0..pattern.blocks()).map(row).collect()
}

/// Ratios of the terms of (T z)˙ and (T z)¨.
const BINOMIAL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 2.0, 1.0]];

impl Linearized {
    /// The equations in multi-blade coordinates of a rotor at an angle and a speed. At angle zero these coordinates are the
    /// rotor's own.
    pub(super) fn in_multi_blade_coordinates(
        &self,
        rotor: &CyclicSymmetry,
        angle: f64,
        speed: f64,
    ) -> Self {
        let old = &self.pattern;
        let T = transformation(rotor, old, angle);
        let pairs = || (0..old.blocks()).flat_map(|j| old.column(j).map(move |(i, at)| (i, j, at)));
        let groups = pairs().filter(|(i, j, _)| i >= j).map(|(i, j, _)| {
            let blocks = T[i].keys().chain(T[j].keys());
            blocks.map(|&block| block as u32).collect::<Vec<_>>()
        });
        let sizes: Vec<usize> = (0..old.blocks()).map(|block| old.size(block)).collect();
        let pattern = BlockPattern::new(&sizes, groups);
        let pattern = pattern.with_coordinates(|u| old.coordinates()[u]);
        let mut matrices = [(); 3].map(|()| vec![0.0; pattern.len()]);
        for (i, j, at) in pairs() {
            let sources = [&self.K, &self.C, &self.M].map(|values| &values[at.clone()]);
            let sources = sources.map(|values| DMatrixView::from_slice(values, sizes[i], sizes[j]));
            let of_rows = T[i].iter().filter(|(_, [T, ..])| T.amax() > NOTHING);
            for (a, [left, ..]) in of_rows {
                let sources = sources.map(|X| left.tr_mul(&X));
                for (b, right) in &T[j] {
                    let Some(first) = pattern.find(*a, *b) else {
                        continue;
                    };
                    let block = first..first + sizes[*a] * sizes[*b];
                    for (order, X) in sources.iter().enumerate() {
                        for k in (0..=order).filter(|&k| right[k].amax() > NOTHING) {
                            let factor = BINOMIAL[order][k] * speed.powi(k as i32);
                            let values = &mut matrices[order - k][block.clone()];
                            DMatrixViewMut::from_slice(values, sizes[*a], sizes[*b])
                                .gemm(factor, X, &right[k], 1.0);
                        }
                    }
                }
            }
        }
        let input = |r_u: &Vec<f64>| {
            let mut out = vec![0.0; r_u.len()];
            for (i, row) in T.iter().enumerate() {
                let own = DVectorView::from_slice(&r_u[old.unknowns(i)], sizes[i]);
                for (a, [left, ..]) in row {
                    DVectorViewMut::from_slice(&mut out[old.unknowns(*a)], sizes[*a])
                        .gemv_tr(1.0, left, &own, 1.0);
                }
            }
            out
        };
        let [K, C, M] = matrices;
        Self {
            pattern,
            K,
            C,
            M,
            r_u: self.r_u.iter().map(input).collect(),
            names: self.names.clone(),
        }
    }
}
