//! The pull-back of tangents from the pose of a child to the pose of its parent.
//!
//! The operator of a joint has the columns A of the parent's pose and S of the joint's own coordinates,
//! A = \[1 −ρ~; 0 1\]. Products with A are sums of columns and rows, so that a link costs little more than
//! the transport of a rigid body (Featherstone 2008):
//!
//! ```text
//! K_jp += K_jn A + C_jn Ȧ + M_jn Ä,   K_pj += Aᵀ K_nj        likewise C, M, and with S
//! ```

#![allow(non_snake_case)]

use crate::model::assembly::scatter::{PulledNode, ScatterTarget, add, products, transposed};
use crate::model::assembly::scatter_map::{BlockPosition, ScatterMap};
use crate::model::{NONE, Node};

/// Number of coordinates of a pose.
const POSE: usize = 6;

/// The lever from the parent to the child with its rates, and the joint's own columns of B, Ḃ and B̈.
struct Columns<'a> {
    rho: [[f64; 3]; 3],
    /// Whether the child is at its parent, as that of a revolute joint: A is the identity.
    at_parent: bool,
    S: [&'a [f64]; 3],
}

impl<'a> Columns<'a> {
    fn of(B: [&'a [f64]; 3]) -> Self {
        let lever = |B: &[f64]| [B[5 * POSE + 1], B[3 * POSE + 2], B[4 * POSE]];
        let rho = B.map(lever);
        Self {
            rho,
            at_parent: rho == [[0.0; 3]; 3],
            S: B.map(|B| &B[POSE * POSE..]),
        }
    }

    /// Multiplies tangents of `height` rows by A and its rates, in place.
    fn carry_columns(&self, tangents: &mut [&mut [f64]], height: usize) {
        if self.at_parent {
            return;
        }
        // Most nodes are poses or angles: loops of constant length.
        match height {
            6 => self.carry_all(tangents, 6),
            1 => self.carry_all(tangents, 1),
            _ => self.carry_all(tangents, height),
        }
    }

    #[inline(always)]
    fn carry_all(&self, tangents: &mut [&mut [f64]], height: usize) {
        for order in 0..tangents.len() {
            let (to, rest) = tangents.split_at_mut(order + 1);
            let (first, turned) = to[order].split_at_mut(3 * height);
            lever(first, turned, height, self.rho[0], 1.0);
            for (rate, higher) in rest.iter().enumerate() {
                let factor = if order == 1 { 2.0 } else { 1.0 };
                lever(higher, turned, height, self.rho[1 + rate], factor);
            }
        }
    }

    /// Multiplies six rows by Aᵀ, in place.
    fn carry_rows(&self, block: &mut [f64]) {
        if self.at_parent {
            return;
        }
        let [x, y, z] = self.rho[0];
        for c in block.as_chunks_mut::<POSE>().0 {
            c[3] += y * c[2] - z * c[1];
            c[4] += z * c[0] - x * c[2];
            c[5] += x * c[1] - y * c[0];
        }
    }
}

/// turned −= factor first ρ~, of three columns each.
#[inline(always)]
fn lever(first: &[f64], turned: &mut [f64], height: usize, rho: [f64; 3], factor: f64) {
    let [x, y, z] = rho.map(|rho| factor * rho);
    let (a, rest) = first[..3 * height].split_at(height);
    let (b, c) = rest.split_at(height);
    let (p, rest) = turned.split_at_mut(height);
    let (q, r) = rest.split_at_mut(height);
    for k in 0..height {
        p[k] += y * c[k] - z * b[k];
        q[k] += z * a[k] - x * c[k];
        r[k] += x * b[k] - y * a[k];
    }
}

impl ScatterMap {
    /// As [`ScatterMap::pull_back`], for a joint between two poses, the first parent and the child.
    pub(in crate::model) fn pull_back_link(
        &self,
        link: &PulledNode<'_>,
        nodes: &[Node],
        K_sigma: &[f64],
        orders: usize,
        into: &mut ScatterTarget<'_>,
        work: &mut [f64],
    ) {
        let columns = Columns::of(link.B);
        let (parent, own_parents) = link.parents.split_at(1);
        let d = link.B[0].len() / POSE;
        let D = d - POSE;
        let coupled = &self.couplings.0[link.index];
        let (above, own) = into.coupled.split_at_mut(coupled.diagonal);
        let mut into = ScatterTarget {
            values: into.values,
            coupled: above,
            weights: into.weights,
        };
        let (product, pulled) = work.split_at_mut(work.len() / 2);
        let mut positions = &self.positions[coupled.first_position..];
        for partner in &coupled.partners {
            let other = std::slice::from_ref(&partner.node);
            let height = nodes[partner.node as usize].dim;
            let size = POSE * height;
            let (rows, rest) = positions.split_at(link.parents.len());
            let (other_columns, rest) = rest.split_at(link.parents.len());
            positions = rest;
            let first = partner.row - coupled.diagonal;
            let blocks = own[first..first + 3 * size].chunks_exact_mut(size);
            for (order, block) in blocks.enumerate().take(orders) {
                if block.iter().all(|f| *f == 0.0) {
                    continue;
                }
                if D > 0 {
                    transposed(columns.S[0], block, (POSE, D), pulled);
                    let sets = [own_parents, other];
                    self.add(nodes, sets, &rows[1..], (pulled, D), order, &mut into);
                }
                columns.carry_rows(block);
                into.add_block(rows[0], order, block);
            }
            let first = partner.column - coupled.diagonal;
            let mut blocks = split(&mut own[first..first + 3 * size], size);
            let blocks = &mut blocks[..orders];
            for order in (0..orders).filter(|_| D > 0) {
                products(&blocks[order..], columns.S, order, (POSE, height), product);
                let sets = [other, own_parents];
                let from = (&*product, height);
                self.add(nodes, sets, &other_columns[1..], from, order, &mut into);
            }
            columns.carry_columns(blocks, height);
            for (order, block) in blocks.iter().enumerate() {
                into.add_block(other_columns[0], order, block);
            }
        }
        // Positions of the columns of the parent, and of those of each own coordinate.
        let (of_parent, of_own) = positions.split_at(link.parents.len());
        let mut blocks = split(&mut own[..3 * POSE * POSE], POSE * POSE);
        let blocks = &mut blocks[..orders];
        for order in (0..orders).filter(|_| D > 0) {
            products(&blocks[order..], columns.S, order, (POSE, POSE), product);
            let right = &mut product[..POSE * D];
            transposed(columns.S[0], right, (POSE, D), pulled);
            columns.carry_rows(right);
            if order == 0 {
                for (k, G) in K_sigma[POSE * d..].chunks_exact(d).enumerate() {
                    add(&mut right[k * POSE..][..POSE], G, -1.0);
                    add(&mut pulled[k * D..][..D], &G[POSE..], -1.0);
                }
            }
            let mut column = 0;
            for (k, j) in own_parents.iter().enumerate() {
                let width = nodes[*j as usize].dim;
                let positions = &of_own[k * link.parents.len()..][..link.parents.len()];
                let [right, pulled] = [(&*right, POSE), (&*pulled, D)]
                    .map(|(values, height)| &values[column * height..][..width * height]);
                into.add_block(positions[0], order, right);
                let sets = [own_parents, std::slice::from_ref(j)];
                self.add(nodes, sets, &positions[1..], (pulled, D), order, &mut into);
                column += width;
            }
        }
        columns.carry_columns(blocks, POSE);
        for (order, block) in blocks.iter_mut().enumerate() {
            if D > 0 {
                transposed(columns.S[0], block, (POSE, D), pulled);
                if order == 0 {
                    for (to, G) in pulled
                        .chunks_exact_mut(D)
                        .zip(K_sigma.chunks_exact(d))
                        .take(POSE)
                    {
                        add(to, &G[POSE..], -1.0);
                    }
                }
                let sets = [own_parents, parent];
                self.add(nodes, sets, &of_parent[1..], (pulled, D), order, &mut into);
            }
            columns.carry_rows(block);
            if order == 0 {
                for (to, G) in block.chunks_exact_mut(POSE).zip(K_sigma.chunks_exact(d)) {
                    add(to, G, -1.0);
                }
            }
            into.add_block(of_parent[0], order, block);
        }
    }
}

impl ScatterTarget<'_> {
    /// Adds a whole block of order 0, 1 or 2 among those of mapped nodes.
    fn add_block(&mut self, position: BlockPosition, order: usize, block: &[f64]) {
        if position.start != NONE {
            let first = position.start as usize + order * block.len();
            add(&mut self.coupled[first..first + block.len()], block, 1.0);
        }
    }
}

/// K, C and M of a block.
fn split(blocks: &mut [f64], size: usize) -> [&mut [f64]; 3] {
    let (K, rest) = blocks.split_at_mut(size);
    let (C, M) = rest.split_at_mut(size);
    [K, C, M]
}
