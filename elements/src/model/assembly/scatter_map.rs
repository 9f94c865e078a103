//! Positions of element matrices in the pattern.

use crate::model::assembly::couplings::{CoupledBlock, Couplings};
use crate::model::assembly::pull_back::Piece;
use crate::model::kinematics::mapped_node::Maps;
use crate::model::{ElementEntry, NONE, Node, Nodes, Span};
use pullback_manifold::sparse::BlockPattern;
use std::ops::Range;

/// Positions of element matrices in the pattern, found for the present segments of all maps.
///
/// Stored in the order of an assembly. Tangents at mapped nodes have blocks of their own
/// ([`Couplings`]), which are pulled back to their parents, like forces.
#[derive(Clone, Default)]
pub(in crate::model) struct ScatterMap {
    /// Per coordinate: its row in the block of its own node, [`NONE`] if prescribed.
    pub rows: Vec<u32>,
    /// Per node: index of its block in the pattern, [`NONE`] if all is prescribed.
    pub blocks: Vec<u32>,
    /// Per element without mapped nodes, consecutively: the position of each pair of blocks, column by column.
    positions: Vec<BlockPosition>,
    /// Per element: its first position, or piece with mapped nodes.
    pub(super) first_positions: Vec<usize>,
    pub couplings: Couplings,
    /// The same for elements with mapped nodes, and positions of the tangents that mapped nodes pass to their
    /// parents.
    pub(super) pieces: Vec<Piece>,
    /// Per value: whether the first element with the block that begins here writes it; `None` without one.
    written: Vec<Option<bool>>,
    /// Values that are only added to.
    unwritten: Vec<Range<usize>>,
}

/// Position of the rows of one node and the columns of another in the pattern.
#[derive(Clone, Copy)]
struct BlockPosition {
    /// First value, [`NONE`] if there is no block.
    start: u32,
    /// Whether an assembly writes it here first, so that it need not be cleared.
    first: bool,
}

impl ScatterMap {
    /// Without positions, for nodes with `coordinates` in all.
    pub(in crate::model) fn new(nodes: usize, coordinates: usize) -> Self {
        Self {
            rows: vec![NONE; coordinates],
            blocks: vec![NONE; nodes],
            ..Self::default()
        }
    }

    /// Makes room for any segments, so that a change of segment allocates nothing; returns the number of
    /// values of the blocks of mapped nodes, and of scratch to pull them back.
    pub(in crate::model) fn arrange(
        &mut self,
        nodes: &Nodes,
        elements: &[ElementEntry],
    ) -> [usize; 2] {
        let (couplings, blocks) = (&mut self.couplings, &self.blocks);
        let len = couplings.find(nodes, elements, blocks, |d| &d.segments);
        let of_elements = |mapped: bool| -> usize {
            let all = elements.iter().filter(|e| !e.dead && e.mapped == mapped);
            all.map(|e| e.nodes.len().pow(2)).sum()
        };
        let (positions, mut pieces) = (of_elements(false), of_elements(true));
        let mut scratch = 0;
        for (coupled, (_, node, d)) in couplings.0.iter_mut().zip(nodes.mapped()) {
            let parents = d.segments.iter().map(Vec::len).max().unwrap_or(0);
            coupled.parents.reserve_exact(parents);
            pieces += parents * (parents + 2 * coupled.partners.len());
            // Vectors and matrices of the pull-back.
            scratch = scratch.max(3 * (1 + node.dim) * d.direct);
        }
        self.positions.reserve_exact(positions);
        self.pieces.reserve_exact(pieces);
        self.first_positions.reserve_exact(elements.len());
        [len, scratch]
    }

    /// Finds the positions of all blocks of elements and of mapped nodes.
    pub(in crate::model) fn locate(
        &mut self,
        nodes: &Nodes,
        maps: &Maps,
        elements: &[ElementEntry],
        pattern: &BlockPattern,
    ) {
        let (couplings, blocks) = (&mut self.couplings, &self.blocks);
        couplings.find(nodes, elements, blocks, |d| {
            std::slice::from_ref(&d.segments[maps[d.index].segment()])
        });
        self.positions.clear();
        self.first_positions.clear();
        self.written.clear();
        self.written.resize(pattern.len(), None);
        self.pieces.clear();
        for e in elements {
            self.locate_element(nodes, e, pattern);
        }
        for (k, (_, _, d)) in nodes.mapped().enumerate() {
            if !self.couplings.0[k].loaded {
                continue;
            }
            let parents = d.parents(maps);
            let partners = std::mem::take(&mut self.couplings.0[k].partners);
            let first_piece = self.pieces.len();
            for partner in &partners {
                self.locate_pieces(nodes, parents, partner.node, false, pattern);
                self.locate_pieces(nodes, parents, partner.node, true, pattern);
            }
            for &other in parents {
                self.locate_pieces(nodes, parents, other, false, pattern);
            }
            let coupled = &mut self.couplings.0[k];
            (coupled.partners, coupled.first_piece) = (partners, first_piece);
            coupled.parents.clear();
            let dims = parents.iter().map(|&p| nodes[p as usize].dim);
            coupled.parents.extend(dims);
        }
        let all = (0..pattern.blocks()).flat_map(|j| pattern.column(j));
        self.unwritten.clear();
        // Room for any positions, so that a change of segment allocates nothing.
        self.unwritten.reserve_exact(all.clone().count());
        let unwritten = all.filter(|(_, block)| self.written[block.start] != Some(true));
        self.unwritten.extend(unwritten.map(|(_, block)| block));
    }

    /// Adds the positions of the blocks of an element or, with mapped nodes, its pieces.
    fn locate_element(&mut self, nodes: &[Node], e: &ElementEntry, pattern: &BlockPattern) {
        let (position, piece) = (self.positions.len(), self.pieces.len());
        let first = if e.mapped { piece } else { position };
        self.first_positions.push(first);
        for &j in e.nodes.iter().filter(|_| !e.dead) {
            if e.mapped {
                self.locate_pieces(nodes, &e.nodes, j, false, pattern);
                continue;
            }
            for &i in e.nodes.iter() {
                self.locate_block([i, j], pattern);
            }
        }
        for piece in &self.pieces[piece..] {
            if let (Some(block), Some(_)) = (piece.block, piece.own) {
                self.written[block.start].get_or_insert(false);
            }
        }
    }

    /// Adds the position of the rows of node i and the columns of node j.
    fn locate_block(&mut self, [i, j]: [u32; 2], pattern: &BlockPattern) {
        let found = self.pattern_block(i, j, pattern);
        let first = found.is_some_and(|start| self.written[start].is_none());
        if let Some(start) = found {
            self.written[start].get_or_insert(true);
        }
        let start = found.map_or(NONE, |start| start as u32);
        self.positions.push(BlockPosition { start, first });
    }

    /// First value of the block with the rows of own node i and the columns of own node j.
    fn pattern_block(&self, i: u32, j: u32, pattern: &BlockPattern) -> Option<usize> {
        let [row, column] = [i, j].map(|n| self.blocks[n as usize]);
        (row != NONE && column != NONE)
            .then(|| pattern.find(row as usize, column as usize))
            .flatten()
    }

    /// Adds the pieces of a group of nodes with another node: their rows and its columns or, `transposed`, the
    /// other way round.
    fn locate_pieces(
        &mut self,
        nodes: &[Node],
        group: &[u32],
        other: u32,
        transposed: bool,
        pattern: &BlockPattern,
    ) {
        let mut first = 0;
        for &member in group {
            let [node, partner] = [member, other].map(|n| &nodes[n as usize]);
            let [i, j] = if transposed {
                [other, member]
            } else {
                [member, other]
            };
            let own = node.is_own() && partner.is_own();
            let block = if own {
                let rows = &self.rows[nodes[i as usize].range()];
                let height = rows.iter().filter(|&&r| r != NONE).count();
                let start = self.pattern_block(i, j, pattern);
                start.map(|start| CoupledBlock {
                    start,
                    row: 1,
                    column: height,
                    order: 0,
                })
            } else {
                self.couplings.block(nodes, i, j)
            };
            let len = node.dim as u32;
            self.pieces.push(Piece {
                first,
                len,
                block: if transposed {
                    block.map(CoupledBlock::transposed)
                } else {
                    block
                },
                own: own.then_some([node.first as u32, partner.first as u32]),
            });
            first += len;
        }
    }

    /// Clears the values that no element writes; [`ScatterMap::scatter`] of all elements then fills
    /// the rest.
    pub(in crate::model) fn clear_unwritten(&self, values: &mut [f64]) {
        for block in &self.unwritten {
            values[block.clone()].fill(0.0);
        }
    }

    /// Writes or adds the local matrix `S` (d×d) of element `k`.
    pub(in crate::model) fn scatter(
        &self,
        k: usize,
        e: &ElementEntry,
        spans: &[Span],
        S: &[f64],
        values: &mut [f64],
    ) {
        let nodes = &e.nodes[..];
        let positions = &self.positions[self.first_positions[k]..][..nodes.len() * nodes.len()];
        let d = e.element.dim();
        let mut column = 0;
        for (&nj, positions) in nodes.iter().zip(positions.chunks_exact(nodes.len())) {
            let columns = spans[nj as usize].range();
            let mut row = 0;
            for (&ni, position) in nodes.iter().zip(positions) {
                let rows = spans[ni as usize].range();
                let size = (rows.len(), columns.len());
                if position.start != NONE {
                    let (S, values) = (
                        &S[row + column * d..],
                        &mut values[position.start as usize..],
                    );
                    let first = position.first;
                    // Most nodes are frames with all coordinates free: constant extents.
                    if e.dependent_coordinates || size != (6, 6) || !d.is_multiple_of(6) {
                        let (rows, columns) = (&self.rows[rows], &self.rows[columns.clone()]);
                        free_part((rows, columns), (S, d), values, first);
                    } else if first {
                        whole_block(S, d / 6, values, |value, s| *value = s);
                    } else {
                        whole_block(S, d / 6, values, |value, s| *value += s);
                    }
                }
                row += size.0;
            }
            column += columns.len();
        }
    }
}

/// Applies `put` to a 6×6 block and its values; `S` has leading dimension 6·stride.
#[inline(always)]
fn whole_block(S: &[f64], stride: usize, values: &mut [f64], put: impl Fn(&mut f64, f64)) {
    let values: Option<&mut [[f64; 6]; 6]> = values.as_chunks_mut().0.first_chunk_mut();
    let S = S.as_chunks::<6>().0.iter().step_by(stride);
    for (values, S) in values.into_iter().flatten().zip(S) {
        for k in 0..6 {
            put(&mut values[k], S[k]);
        }
    }
}

/// Writes or adds the free rows and columns of one dense block; `S` has leading dimension d.
fn free_part(
    (rows, columns): (&[u32], &[u32]),
    (S, d): (&[f64], usize),
    values: &mut [f64],
    first: bool,
) {
    let height = rows.iter().filter(|&&r| r != NONE).count();
    for (c, &column) in columns.iter().enumerate() {
        if column == NONE {
            continue;
        }
        for (r, &row) in rows.iter().enumerate() {
            if row != NONE {
                let value = &mut values[row as usize + column as usize * height];
                let s = S[r + c * d];
                *value = if first { s } else { *value + s };
            }
        }
    }
}
