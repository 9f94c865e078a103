//! Where local matrices go in the pattern: found once, looked up by position afterwards.

#![allow(non_snake_case)]

use super::{Attached, NONE, Node, Source};
use pullback_manifold::sparse::BlockPattern;

/// Where local matrices go in the pattern: found once, looked up by position afterwards.
#[derive(Default)]
pub(super) struct Placement {
    /// Per own node: row of each coordinate inside its block, [`NONE`] when prescribed.
    pub rows: Vec<Vec<u32>>,
    /// Per own node: number of its block in the pattern, [`NONE`] when all is prescribed.
    pub blocks: Vec<u32>,
    /// Per element, consecutively: own node of each block.
    pub nodes: Vec<u32>,
    /// Per element, consecutively: first value of each pair of blocks, column by column.
    pub positions: Vec<u32>,
}

impl Placement {
    /// Finds the own nodes behind each element and the places of all their pairs of blocks.
    pub(super) fn locate(
        &mut self,
        nodes: &[Node],
        elements: &mut [Attached],
        pattern: &BlockPattern,
    ) {
        self.nodes.clear();
        self.positions.clear();
        let blocks = &self.blocks;
        let block_of = |n: u32| Some(blocks[n as usize]).filter(|&b| b != NONE);
        for e in elements {
            e.first_block = self.nodes.len();
            e.first_position = self.positions.len();
            e.mapped = false;
            for &n in &e.nodes {
                match &nodes[n as usize].source {
                    Source::Own => self.nodes.push(n),
                    Source::Mapped(d) => {
                        e.mapped = true;
                        self.nodes.extend(&d.ancestors);
                    }
                }
            }
            let own = &self.nodes[e.first_block..];
            e.blocks = own.len();
            e.pulled = own.iter().map(|&n| nodes[n as usize].dim).sum();
            for &nj in own {
                for &ni in own {
                    let start = match (block_of(ni), block_of(nj)) {
                        (Some(i), Some(j)) => pattern.find(i as usize, j as usize),
                        _ => None,
                    };
                    self.positions.push(start.map_or(NONE, |s| s as u32));
                }
            }
        }
    }

    /// Adds an element's local matrix `S` (d×d).
    pub(super) fn scatter(&self, e: &Attached, S: &[f64], values: &mut [f64]) {
        let nodes = &self.nodes[e.first_block..e.first_block + e.blocks];
        let positions = &self.positions[e.first_position..e.first_position + e.blocks * e.blocks];
        let d = e.pulled;
        let mut column = 0;
        for (j, &nj) in nodes.iter().enumerate() {
            let columns = &self.rows[nj as usize];
            let mut row = 0;
            for (i, &ni) in nodes.iter().enumerate() {
                let rows = &self.rows[ni as usize];
                let start = positions[j * nodes.len() + i];
                if start != NONE {
                    add_block(
                        rows,
                        columns,
                        &S[row + column * d..],
                        d,
                        &mut values[start as usize..],
                    );
                }
                row += rows.len();
            }
            column += columns.len();
        }
    }

    /// Adds a matrix (d×d) over the blocks of own nodes, found by search.
    pub(super) fn scatter_nodes(
        &self,
        nodes: &[u32],
        S: &[f64],
        d: usize,
        pattern: &BlockPattern,
        values: &mut [f64],
    ) {
        let mut column = 0;
        for &nj in nodes {
            let columns = &self.rows[nj as usize];
            let mut row = 0;
            for &ni in nodes {
                let rows = &self.rows[ni as usize];
                let (bi, bj) = (self.blocks[ni as usize], self.blocks[nj as usize]);
                if bi != NONE
                    && bj != NONE
                    && let Some(start) = pattern.find(bi as usize, bj as usize)
                {
                    add_block(
                        rows,
                        columns,
                        &S[row + column * d..],
                        d,
                        &mut values[start..],
                    );
                }
                row += rows.len();
            }
            column += columns.len();
        }
    }
}

/// Adds one dense block, leaving out prescribed rows and columns; `S` has leading dimension d.
#[inline]
fn add_block(rows: &[u32], columns: &[u32], S: &[f64], d: usize, values: &mut [f64]) {
    let height = rows.iter().filter(|&&r| r != NONE).count();
    if height == 6 && rows.len() == 6 && columns.len() == 6 && columns.iter().all(|&c| c != NONE) {
        for (c, values) in values[..36].chunks_exact_mut(6).enumerate() {
            for (value, s) in values.iter_mut().zip(&S[c * d..c * d + 6]) {
                *value += s;
            }
        }
        return;
    }
    for (c, &column) in columns.iter().enumerate() {
        if column == NONE {
            continue;
        }
        for (r, &row) in rows.iter().enumerate() {
            if row != NONE {
                values[row as usize + column as usize * height] += S[r + c * d];
            }
        }
    }
}
