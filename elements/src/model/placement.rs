//! Where local matrices go in the pattern: found once, looked up by position afterwards.

#![allow(non_snake_case)]

use super::{Attached, NONE, Node, Source, Span};
use pullback_manifold::sparse::BlockPattern;
use std::ops::Range;

/// Where local matrices go in the pattern: found once, looked up by position afterwards.
///
/// Everything is stored in the order in which an assembly walks through it.
#[derive(Default)]
pub(super) struct Placement {
    /// Per coordinate: its row inside the block of its own node, [`NONE`] when prescribed.
    pub rows: Vec<u32>,
    /// Per node: number of its block in the pattern, [`NONE`] when all is prescribed.
    pub blocks: Vec<u32>,
    /// Per element, consecutively: own node of each block.
    nodes: Vec<u32>,
    /// Per element, consecutively: the place of each pair of blocks, column by column.
    places: Vec<Place>,
    /// Per value: whether an element writes the block that begins there.
    written: Vec<bool>,
    /// Values that no element writes.
    unwritten: Vec<Range<usize>>,
}

/// Where a pair of own nodes stands in the pattern.
#[derive(Clone, Copy)]
struct Place {
    /// First value, [`NONE`] when there is no block.
    start: u32,
    /// Whether it is written here for the first time in an assembly, so that nothing has to be
    /// cleared beforehand.
    first: bool,
    /// Whether both nodes are frames without supports: the block is full, six by six.
    frames: bool,
}

impl Placement {
    /// Nothing placed yet, for nodes with `coordinates` in all.
    pub(super) fn new(nodes: usize, coordinates: usize) -> Self {
        Self {
            rows: vec![NONE; coordinates],
            blocks: vec![NONE; nodes],
            ..Self::default()
        }
    }

    /// Finds the own nodes behind each element and the places of all their pairs of blocks.
    pub(super) fn locate(
        &mut self,
        nodes: &[Node],
        elements: &mut [Attached],
        pattern: &BlockPattern,
    ) {
        self.nodes.clear();
        self.places.clear();
        let blocks = &self.blocks;
        let block_of = |n: u32| Some(blocks[n as usize]).filter(|&b| b != NONE);
        let written = &mut self.written;
        written.clear();
        written.resize(pattern.len(), false);
        for e in elements {
            e.first_block = self.nodes.len();
            e.first_place = self.places.len();
            e.mapped = false;
            let held = |&n: &u32| self.rows[nodes[n as usize].range()].contains(&NONE);
            e.held = e.nodes.iter().any(held);
            for &n in e.nodes.iter() {
                match &nodes[n as usize].source {
                    Source::Own => self.nodes.push(n),
                    Source::Mapped(d) => {
                        e.mapped = true;
                        self.nodes.extend(&d.ancestors);
                    }
                }
            }
            let own = &self.nodes[e.first_block..];
            let frame = |n: u32| {
                let rows = &self.rows[nodes[n as usize].range()];
                rows.len() == 6 && !rows.contains(&NONE)
            };
            e.blocks = own.len();
            e.pulled = own.iter().map(|&n| nodes[n as usize].dim).sum();
            for &nj in own {
                for &ni in own {
                    let start = match (block_of(ni), block_of(nj)) {
                        (Some(i), Some(j)) => pattern.find(i as usize, j as usize),
                        _ => None,
                    };
                    let first = match start {
                        Some(start) if !e.dead => !std::mem::replace(&mut written[start], true),
                        _ => false,
                    };
                    self.places.push(Place {
                        start: start.map_or(NONE, |s| s as u32),
                        first,
                        frames: frame(ni) && frame(nj),
                    });
                }
            }
        }
        let all = (0..pattern.blocks()).flat_map(|j| pattern.column(j));
        self.unwritten.clear();
        // Room for any other places: nothing is allocated when a map is handed over.
        self.unwritten.reserve_exact(all.clone().count());
        let unwritten = all.filter(|(_, block)| !written[block.start]);
        self.unwritten.extend(unwritten.map(|(_, block)| block));
    }

    /// Clears what no element writes; [`Placement::scatter`] of all elements then fills the rest.
    pub(super) fn clear_unwritten(&self, values: &mut [f64]) {
        for block in &self.unwritten {
            values[block.clone()].fill(0.0);
        }
    }

    /// Writes or adds an element's local matrix `S` (d×d).
    pub(super) fn scatter(&self, e: &Attached, spans: &[Span], S: &[f64], values: &mut [f64]) {
        let nodes = &self.nodes[e.first_block..e.first_block + e.blocks];
        let places = &self.places[e.first_place..e.first_place + e.blocks * e.blocks];
        let d = e.pulled;
        let mut column = 0;
        for (&nj, places) in nodes.iter().zip(places.chunks_exact(nodes.len())) {
            let columns = &self.rows[spans[nj as usize].range()];
            let mut row = 0;
            for (&ni, place) in nodes.iter().zip(places) {
                let rows = &self.rows[spans[ni as usize].range()];
                if place.start != NONE {
                    let (S, values) = (&S[row + column * d..], &mut values[place.start as usize..]);
                    if place.frames {
                        add_frames(place.first, S, d, values);
                    } else if place.first {
                        visit_block(rows, columns, S, d, values, |value, s| *value = s);
                    } else {
                        visit_block(rows, columns, S, d, values, |value, s| *value += s);
                    }
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
        spans: &[Span],
        (S, d): (&[f64], usize),
        pattern: &BlockPattern,
        values: &mut [f64],
    ) {
        let mut column = 0;
        for &nj in nodes {
            let columns = &self.rows[spans[nj as usize].range()];
            let mut row = 0;
            for &ni in nodes {
                let rows = &self.rows[spans[ni as usize].range()];
                let (bi, bj) = (self.blocks[ni as usize], self.blocks[nj as usize]);
                if bi != NONE
                    && bj != NONE
                    && let Some(start) = pattern.find(bi as usize, bj as usize)
                {
                    let (S, values) = (&S[row + column * d..], &mut values[start..]);
                    visit_block(rows, columns, S, d, values, |value, s| *value += s);
                }
                row += rows.len();
            }
            column += columns.len();
        }
    }
}

/// Takes the block of two frames to its values, or adds it to them; `S` has leading dimension d.
#[inline(always)]
fn add_frames(first: bool, S: &[f64], d: usize, values: &mut [f64]) {
    let values = values[..36].as_chunks_mut::<6>().0;
    for (values, S) in values.iter_mut().zip(S.chunks(d)) {
        let Some(S) = S.first_chunk::<6>() else {
            return;
        };
        if first {
            *values = *S;
        } else {
            for (value, s) in values.iter_mut().zip(S) {
                *value += s;
            }
        }
    }
}

/// Takes one dense block to its values, leaving out prescribed rows and columns; `S` has leading
/// dimension d.
#[inline(always)]
fn visit_block(
    rows: &[u32],
    columns: &[u32],
    S: &[f64],
    d: usize,
    values: &mut [f64],
    put: impl Fn(&mut f64, f64),
) {
    let free = |rows: &[u32]| rows.iter().filter(|&&r| r != NONE).count();
    let height = free(rows);
    for (c, &column) in columns.iter().enumerate() {
        if column == NONE {
            continue;
        }
        for (r, &row) in rows.iter().enumerate() {
            if row != NONE {
                put(
                    &mut values[row as usize + column as usize * height],
                    S[r + c * d],
                );
            }
        }
    }
}
