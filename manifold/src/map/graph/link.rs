//! One map of a graph, with the chain rule.

#![allow(
    clippy::needless_range_loop,
    reason = "orders of derivatives and matrices in slices are read by their indices"
)]

use super::{Parametrization, Read};

/// One map of a graph, with its results.
#[derive(Clone)]
pub(super) struct Link {
    pub map: Box<dyn Parametrization>,
    /// Sources of the coordinates, and the number of each.
    pub reads: Vec<(Read, usize)>,
    /// Inputs that it depends on, ascending, and for each source the indices of its inputs among them.
    pub columns: Vec<usize>,
    pub positions: Vec<Vec<usize>>,
    pub n: usize,
    pub d: usize,
    /// Coordinates and their rates, values and their rates.
    pub q: [Vec<f64>; 3],
    pub x: [Vec<f64>; 3],
    /// B, Ḃ, B̈ with respect to the coordinates, and to the inputs in `columns`.
    pub own: [Vec<f64>; 3],
    pub all: [Vec<f64>; 3],
    pub r: Vec<f64>,
}

/// Factors of a product of operators of two orders.
const BINOMIAL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 2.0, 1.0]];

impl Link {
    /// Collects the coordinates, up to the given order of their derivatives.
    pub(super) fn gather(&mut self, before: &[Self], y: [&[f64]; 3], orders: usize) {
        for k in 0..orders {
            let mut at = 0;
            for &(read, len) in &self.reads {
                let to = &mut self.q[k][at..at + len];
                match read {
                    Read::Input(first) => to.copy_from_slice(&y[k][first..first + len]),
                    Read::Nothing => to.fill(0.0),
                    Read::Link(j) => to.copy_from_slice(&before[j].x[k]),
                }
                at += len;
            }
        }
    }

    /// Evaluates these orders of its map at the coordinates.
    pub(super) fn evaluate(&mut self, t: f64, orders: usize) {
        let motion = self.q.each_ref().map(|q| &q[..]);
        let [x, x_dot, x_ddot] = self.x.each_mut().map(|x| &mut x[..]);
        let [B, B_dot, B_ddot] = self.own.each_mut().map(|B| &mut B[..]);
        let out = &mut [[x, B], [x_dot, B_dot], [x_ddot, B_ddot]];
        self.map.evaluate(t, motion, &mut out[..orders]);
    }

    /// Computes operators with respect to the inputs, by the chain rule.
    pub(super) fn chain(&mut self, before: &[Self], orders: usize) {
        let n = self.n;
        for k in 0..orders {
            let out = &mut self.all[k];
            out.fill(0.0);
            let mut column = 0;
            for (&(read, len), positions) in self.reads.iter().zip(&self.positions) {
                match read {
                    Read::Nothing => {}
                    Read::Input(_) => {
                        let from = self.own[k][column * n..(column + len) * n].chunks_exact(n);
                        for (&position, B) in positions.iter().zip(from) {
                            let out = &mut out[position * n..(position + 1) * n];
                            out.iter_mut().zip(B).for_each(|(o, b)| *o += b);
                        }
                    }
                    Read::Link(j) => {
                        for (inner, &factor) in BINOMIAL[k].iter().enumerate().take(k + 1) {
                            let outer = &self.own[k - inner][column * n..(column + len) * n];
                            // Most maps lead from pose to pose.
                            if [n, len] == [6, 6] {
                                let (A, to) = (outer.as_chunks().0, out.as_chunks_mut().0);
                                let from = before[j].all[inner].as_chunks().0;
                                for (&position, B) in positions.iter().zip(from) {
                                    add_product_6(factor, A, B, &mut to[position]);
                                }
                                continue;
                            }
                            let from = before[j].all[inner].chunks_exact(len);
                            for (&position, B) in positions.iter().zip(from) {
                                let out = &mut out[position * n..(position + 1) * n];
                                add_product([n, len], factor, outer, B, out);
                            }
                        }
                    }
                }
                column += len;
            }
        }
    }
}

/// out += factor A B, with A n×len.
pub(super) fn add_product(
    [n, len]: [usize; 2],
    factor: f64,
    A: &[f64],
    B: &[f64],
    out: &mut [f64],
) {
    for (out, B) in out.chunks_exact_mut(n).zip(B.chunks_exact(len)) {
        for (A, b) in A.chunks_exact(n).zip(B) {
            let b = factor * b;
            if b != 0.0 {
                for (o, a) in out.iter_mut().zip(A) {
                    *o += a * b;
                }
            }
        }
    }
}

/// The same for one column from pose to pose.
#[inline]
fn add_product_6(factor: f64, A: &[[f64; 6]], B: &[f64; 6], out: &mut [f64; 6]) {
    for (A, b) in A.iter().zip(B) {
        let b = factor * b;
        for k in 0..6 {
            out[k] += A[k] * b;
        }
    }
}
