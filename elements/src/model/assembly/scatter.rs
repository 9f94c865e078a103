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

/// Destination of a scatter.
pub(in crate::model) struct ScatterTarget<'a> {
    /// Values of the pattern, and of the blocks of mapped nodes.
    pub values: &'a mut [f64],
    pub coupled: &'a mut [f64],
    /// cK, cC, cM.
    pub weights: [f64; 3],
}

/// A mapped node, its parents and its operators B, Ḃ, B̈.
pub(in crate::model) struct PulledNode<'a> {
    pub node: u32,
    pub index: usize,
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
        let positions = &self.positions[self.first_position(k)..];
        for (order, tangent) in tangents.iter().enumerate() {
            if order > 0 && tangent.iter().all(|s| *s == 0.0) {
                continue;
            }
            let from = (*tangent, e.element.dim());
            self.add(nodes, [&e.nodes, &e.nodes], positions, from, order, into);
        }
    }

    /// Adds a matrix of K, C or M (order 0, 1, 2), given with its leading dimension, over the coordinates
    /// of some nodes at the positions of their blocks.
    pub(super) fn add(
        &self,
        nodes: &[Node],
        [rows, columns]: [&[u32]; 2],
        positions: &[BlockPosition],
        (from, stride): (&[f64], usize),
        order: usize,
        into: &mut ScatterTarget<'_>,
    ) {
        let mut positions = positions.iter();
        let mut column = 0;
        for &j in columns {
            let columns = &nodes[j as usize];
            let mut row = 0;
            for (&i, position) in rows.iter().zip(&mut positions) {
                let rows = &nodes[i as usize];
                let from = &from[column * stride + row..];
                row += rows.dim;
                let start = position.start as usize;
                if position.start == NONE {
                    continue;
                }
                if rows.is_own() && columns.is_own() {
                    let block = (&self.rows[rows.range()], &self.rows[columns.range()]);
                    let first = position.first && order == 0;
                    let values = &mut into.values[start..];
                    free_part(block, (from, stride), into.weights[order], values, first);
                    continue;
                }
                let first = start + order * rows.dim * columns.dim;
                let to = into.coupled[first..].chunks_exact_mut(rows.dim);
                for (to, from) in to.zip(from.chunks(stride)).take(columns.dim) {
                    add(to, &from[..rows.dim], 1.0);
                }
            }
            column += columns.dim;
        }
    }

    /// Pulls the tangents at a mapped node back to its parents: three orders in motion, one in statics.
    /// `work` has room for two blocks of any node or of all its parents.
    pub(in crate::model) fn pull_back(
        &self,
        link: &PulledNode<'_>,
        nodes: &[Node],
        K_sigma: &[f64],
        orders: usize,
        into: &mut ScatterTarget<'_>,
        work: &mut [f64],
    ) {
        let PulledNode { parents, B, .. } = *link;
        let n = nodes[link.node as usize].dim;
        let d = B[0].len() / n;
        let coupled = &self.couplings.0[link.index];
        // The blocks of parents come before those of the nodes mapped from them.
        let (above, own) = into.coupled.split_at_mut(coupled.diagonal);
        let mut into = ScatterTarget {
            values: into.values,
            coupled: above,
            weights: into.weights,
        };
        let (product, pulled) = work.split_at_mut(work.len() / 2);
        let blocks = |start: usize, size: usize| {
            [0, 1, 2].map(|order| &own[start - coupled.diagonal + order * size..][..size])
        };
        let mut positions = &self.positions[coupled.first_position..];
        for partner in &coupled.partners {
            let other = std::slice::from_ref(&partner.node);
            let height = nodes[partner.node as usize].dim;
            let (rows, rest) = positions.split_at(parents.len());
            let (columns, rest) = rest.split_at(parents.len());
            positions = rest;
            for (order, block) in blocks(partner.row, n * height)[..orders].iter().enumerate() {
                if block.iter().any(|f| *f != 0.0) {
                    transposed(B[0], block, (n, d), pulled);
                    self.add(nodes, [parents, other], rows, (pulled, d), order, &mut into);
                }
            }
            let tangents = blocks(partner.column, n * height);
            for order in 0..orders {
                products(&tangents[order..orders], B, order, (n, height), product);
                let from = (&*product, height);
                self.add(nodes, [other, parents], columns, from, order, &mut into);
            }
        }
        let tangents = blocks(coupled.diagonal, n * n);
        for order in 0..orders {
            products(&tangents[order..orders], B, order, (n, n), product);
            transposed(B[0], &product[..n * d], (n, d), pulled);
            if order == 0 {
                add(&mut pulled[..d * d], K_sigma, -1.0);
            }
            self.add(
                nodes,
                [parents, parents],
                positions,
                (pulled, d),
                order,
                &mut into,
            );
        }
    }
}

/// K B + C Ḃ + M B̈ (order 0), C B + 2 M Ḃ (1) or M B (2) from the tangents of this order and higher
/// ones, which have `n` columns of `height` rows.
pub(super) fn products<T: AsRef<[f64]>>(
    tangents: &[T],
    B: [&[f64]; 3],
    order: usize,
    (n, height): (usize, usize),
    out: &mut [f64],
) {
    // Most nodes are frames or angles: sums without loops.
    match height {
        6 => fixed::<6, _>(tangents, B, order, n, out),
        1 => {
            for (c, out) in out.iter_mut().enumerate().take(B[0].len() / n) {
                let terms = tangents.iter().zip(B).zip(FACTORS[order]);
                *out = (terms
                    .map(|((row, B), factor)| factor * dot(&B[c * n..][..n], row.as_ref())))
                .sum();
            }
        }
        _ => {
            out[..height * B[0].len() / n].fill(0.0);
            for ((tangent, B), factor) in tangents.iter().zip(B).zip(FACTORS[order]) {
                for (out, B) in out.chunks_exact_mut(height).zip(B.chunks_exact(n)) {
                    for (b, column) in B.iter().zip(tangent.as_ref().chunks_exact(height)) {
                        add(out, column, factor * b);
                    }
                }
            }
        }
    }
}

/// Binomial coefficients of the orders of B.
const FACTORS: [[f64; 3]; 3] = [[1.0, 1.0, 1.0], [1.0, 2.0, 0.0], [1.0, 0.0, 0.0]];

fn fixed<const H: usize, T: AsRef<[f64]>>(
    tangents: &[T],
    B: [&[f64]; 3],
    order: usize,
    n: usize,
    out: &mut [f64],
) {
    let out = out.as_chunks_mut::<H>().0;
    for (c, out) in out.iter_mut().enumerate().take(B[0].len() / n) {
        let mut sum = [0.0; H];
        for ((tangent, B), factor) in tangents.iter().zip(B).zip(FACTORS[order]) {
            for (b, column) in B[c * n..][..n]
                .iter()
                .zip(tangent.as_ref().as_chunks::<H>().0)
            {
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
pub(super) fn transposed(B: &[f64], F: &[f64], (n, d): (usize, usize), out: &mut [f64]) {
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
pub(super) fn add(out: &mut [f64], x: &[f64], factor: f64) {
    for (o, x) in out.iter_mut().zip(x) {
        *o += factor * x;
    }
}
