//! Tangents of groups with mapped nodes, and their pull-back from node to parents.
//!
//! A mapped node n with the operator B to its parents p is coupled with nodes j and with itself. Their
//! tangents pass to the parents, the last link of a chain first (\[M04\] (180), (183), for a tree the
//! composite-rigid-body algorithm of Featherstone 2008):
//!
//! ```text
//! K_pj += Bᵀ K_nj                                        likewise C, M
//! K_jp += K_jn B + C_jn Ḃ + M_jn B̈     C_jp += C_jn B + 2 M_jn Ḃ     M_jp += M_jn B
//! K_pp += Bᵀ (K_nn B + C_nn Ḃ + M_nn B̈) − K_σ            likewise C, M
//! ```
//!
//! The weighted sum cK K + cC C + cM M is added to the pattern, for own nodes.

#![allow(non_snake_case)]

use crate::model::assembly::scatter_map::{BlockPosition, ScatterMap, free_part};
use crate::model::{ElementEntry, NONE, Node};

/// Destination of a scatter: values of the pattern, and those of mapped nodes.
pub(in crate::model) struct ScatterTarget<'a> {
    pub values: &'a mut [f64],
    pub coupled: &'a mut [f64],
    /// cK, cC, cM.
    pub weights: [f64; 3],
    /// Scratch: two blocks of any node or of all parents of one.
    pub work: &'a mut [f64],
}

/// A block of K, C or M (order 0, 1, 2): rows of one node, columns of another.
#[derive(Clone, Copy)]
struct Block<'a> {
    rows: &'a Node,
    columns: &'a Node,
    order: usize,
    position: BlockPosition,
}

/// A mapped node, its parents and its operators B, Ḃ, B̈.
pub(in crate::model) struct Link<'a> {
    pub index: usize,
    pub n: usize,
    pub parents: &'a [u32],
    pub B: [&'a [f64]; 3],
}

impl ScatterMap {
    /// Adds the tangents K, C and M of element `k`, which has mapped nodes; K alone in statics.
    pub(in crate::model) fn scatter_mapped(
        &self,
        k: usize,
        e: &ElementEntry,
        nodes: &[Node],
        tangents: &[&[f64]],
        into: &mut ScatterTarget<'_>,
    ) {
        let n = e.element.dim();
        let positions = &self.positions[self.first_position(k)..];
        let mut first = 0;
        for (&j, positions) in e.nodes.iter().zip(positions.chunks_exact(e.nodes.len())) {
            let columns = &nodes[j as usize];
            let mut row = 0;
            for (&i, &position) in e.nodes.iter().zip(positions) {
                let rows = &nodes[i as usize];
                for (order, tangent) in tangents.iter().enumerate() {
                    let block = Block {
                        rows,
                        columns,
                        order,
                        position,
                    };
                    let from = (&tangent[first * n + row..], n);
                    self.add_block(block, from, into.weights, into.values, into.coupled);
                }
                row += rows.dim;
            }
            first += columns.dim;
        }
    }

    /// Adds a block, given with its leading dimension, at its position.
    fn add_block(
        &self,
        to: Block<'_>,
        (from, stride): (&[f64], usize),
        weights: [f64; 3],
        values: &mut [f64],
        coupled: &mut [f64],
    ) {
        let (rows, columns) = (to.rows, to.columns);
        let BlockPosition { start, first } = to.position;
        if start == NONE {
            return;
        }
        if rows.is_own() && columns.is_own() {
            let (rows, columns) = (&self.rows[rows.range()], &self.rows[columns.range()]);
            let (first, weight) = (first && to.order == 0, weights[to.order]);
            let values = &mut values[start as usize..];
            free_part((rows, columns), (from, stride), weight, values, first);
            return;
        }
        let height = rows.dim;
        let first = start as usize + to.order * height * columns.dim;
        let to = coupled[first..].chunks_exact_mut(height);
        for (to, from) in to.zip(from.chunks(stride)).take(columns.dim) {
            add(to, &from[..height], 1.0);
        }
    }

    /// Pulls the tangents at a mapped node back to its parents: three orders in motion, one in statics.
    pub(in crate::model) fn pull_back(
        &self,
        link: &Link<'_>,
        nodes: &[Node],
        K_sigma: &[f64],
        orders: usize,
        into: &mut ScatterTarget<'_>,
    ) {
        let Link { n, parents, B, .. } = *link;
        let d = B[0].len() / n;
        let coupled = &self.couplings.0[link.index];
        // The blocks of parents come before those of the nodes mapped from them.
        let (above, own) = into.coupled.split_at_mut(coupled.diagonal);
        let (weights, values) = (into.weights, &mut *into.values);
        let half = into.work.len() / 2;
        let (product, pulled) = into.work.split_at_mut(half);
        let block = |start: usize, order: usize, size: usize| {
            &own[start - coupled.diagonal + order * size..][..size]
        };
        let mut positions = self.positions[coupled.first_position..]
            .chunks_exact(parents.len().max(1))
            .map(|positions| parents.iter().zip(positions));
        let mut next = || positions.next().into_iter().flatten();
        for partner in &coupled.partners {
            let other = &nodes[partner.node as usize];
            let size = n * other.dim;
            let to_rows = next();
            for order in 0..orders {
                let rows = block(partner.row, order, size);
                if rows.iter().all(|f| *f == 0.0) {
                    continue;
                }
                transposed(B[0], rows, (n, d), pulled);
                let mut first = 0;
                for (&p, &position) in to_rows.clone() {
                    let rows = &nodes[p as usize];
                    let block = Block {
                        rows,
                        columns: other,
                        order,
                        position,
                    };
                    self.add_block(block, (&pulled[first..], d), weights, values, above);
                    first += rows.dim;
                }
            }
            let to_columns = next();
            let tangents = [0, 1, 2].map(|k| block(partner.column, k, size));
            for order in 0..orders {
                products(&tangents[order..orders], B, order, (n, other.dim), product);
                let mut first = 0;
                for (&p, &position) in to_columns.clone() {
                    let columns = &nodes[p as usize];
                    let block = Block {
                        rows: other,
                        columns,
                        order,
                        position,
                    };
                    let from = (&product[first * other.dim..], other.dim);
                    self.add_block(block, from, weights, values, above);
                    first += columns.dim;
                }
            }
        }
        let tangents = [0, 1, 2].map(|k| block(coupled.diagonal, k, n * n));
        let first_position = coupled.first_position + 2 * coupled.partners.len() * parents.len();
        for order in 0..orders {
            products(&tangents[order..orders], B, order, (n, n), product);
            transposed(B[0], &product[..n * d], (n, d), pulled);
            if order == 0 {
                add(&mut pulled[..d * d], K_sigma, -1.0);
            }
            let mut positions = self.positions[first_position..].iter();
            let mut column = 0;
            for &p in parents {
                let columns = &nodes[p as usize];
                let mut row = 0;
                for (&i, &position) in parents.iter().zip(&mut positions) {
                    let rows = &nodes[i as usize];
                    let block = Block {
                        rows,
                        columns,
                        order,
                        position,
                    };
                    let from = (&pulled[column * d + row..], d);
                    self.add_block(block, from, weights, values, above);
                    row += rows.dim;
                }
                column += columns.dim;
            }
        }
    }
}

/// K B + C Ḃ + M B̈ (order 0), C B + 2 M Ḃ (1) or M B (2) from the tangents of this order and higher
/// ones, which have `n` columns of `height` rows.
fn products(
    tangents: &[&[f64]],
    B: [&[f64]; 3],
    order: usize,
    (n, height): (usize, usize),
    out: &mut [f64],
) {
    // Most nodes are frames or angles: sums without loops.
    match height {
        6 => fixed::<6>(tangents, B, order, n, out),
        1 => {
            for (c, out) in out.iter_mut().enumerate().take(B[0].len() / n) {
                let terms = tangents.iter().zip(B).zip(FACTORS[order]);
                *out = (terms.map(|((row, B), factor)| factor * dot(&B[c * n..][..n], row))).sum();
            }
        }
        _ => {
            out[..height * B[0].len() / n].fill(0.0);
            for ((tangent, B), factor) in tangents.iter().zip(B).zip(FACTORS[order]) {
                for (out, B) in out.chunks_exact_mut(height).zip(B.chunks_exact(n)) {
                    for (b, column) in B.iter().zip(tangent.chunks_exact(height)) {
                        add(out, column, factor * b);
                    }
                }
            }
        }
    }
}

/// Binomial coefficients of the orders of B.
const FACTORS: [[f64; 3]; 3] = [[1.0, 1.0, 1.0], [1.0, 2.0, 0.0], [1.0, 0.0, 0.0]];

fn fixed<const H: usize>(
    tangents: &[&[f64]],
    B: [&[f64]; 3],
    order: usize,
    n: usize,
    out: &mut [f64],
) {
    let out = out.as_chunks_mut::<H>().0;
    for (c, out) in out.iter_mut().enumerate().take(B[0].len() / n) {
        let mut sum = [0.0; H];
        for ((tangent, B), factor) in tangents.iter().zip(B).zip(FACTORS[order]) {
            for (b, column) in B[c * n..][..n].iter().zip(tangent.as_chunks::<H>().0) {
                let b = factor * b;
                if b != 0.0 {
                    for k in 0..H {
                        sum[k] += b * column[k];
                    }
                }
            }
        }
        *out = sum;
    }
}

/// out = Bᵀ F of a matrix F with `n` rows, where B has `d` columns.
fn transposed(B: &[f64], F: &[f64], (n, d): (usize, usize), out: &mut [f64]) {
    for (f, out) in F.chunks_exact(n).zip(out.chunks_exact_mut(d)) {
        for (o, B) in out.iter_mut().zip(B.chunks_exact(n)) {
            *o = dot(B, f);
        }
    }
}

#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    if let (Ok(a), Ok(b)) = (<&[f64; 6]>::try_from(a), <&[f64; 6]>::try_from(b)) {
        let half = |k: usize| a[k] * b[k] + a[k + 1] * b[k + 1] + a[k + 2] * b[k + 2];
        return half(0) + half(3);
    }
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// out += factor x.
#[inline(always)]
fn add(out: &mut [f64], x: &[f64], factor: f64) {
    for (o, x) in out.iter_mut().zip(x) {
        *o += factor * x;
    }
}
