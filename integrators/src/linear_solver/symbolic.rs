//! Structure of the block factors, found once.

use pullback_manifold::sparse::BlockPattern;

use super::{LinearError, MatrixSymmetry, ordering};
use std::ops::Range;

/// A block column of `L` and block row of `U` with their diagonal block, stored one after the
/// other: `D`, then for each link `L` and `Uᵀ`.
pub(super) struct ColumnPanel {
    /// First unknown in the matrix.
    pub unknown: usize,
    /// First unknown in elimination order.
    pub first: usize,
    /// Number of unknowns.
    pub size: usize,
    /// First value of `D`.
    pub start: usize,
    /// One past the panel's last value.
    pub end: usize,
    /// Number of blocks in the matrix' block column.
    pub blocks: usize,
    /// One past its last entry in the lists of the same name.
    pub links: usize,
    pub targets: usize,
    pub loads: usize,
    pub fills: usize,
}

/// A later node that a panel is coupled to.
pub(super) struct PanelLink {
    /// Its panel.
    pub panel: usize,
    /// Its first unknown in elimination order.
    pub first: usize,
    /// Its number of unknowns.
    pub size: usize,
    /// First value of `L`; `Uᵀ` follows.
    pub start: usize,
}

/// A block, or a pair of blocks, to be copied from the matrix before its first use.
pub(super) struct BlockCopy {
    /// Panels of the block row and the block column; the row comes later or is the same.
    pub row: usize,
    pub column: usize,
    /// First value of block (row, column) in the matrix.
    pub lower: usize,
    /// First value of block (column, row) in the matrix.
    pub upper: usize,
    /// Destination among the factors.
    pub start: usize,
}

/// Everything that does not depend on values.
pub(super) struct Symbolic {
    pub panels: Vec<ColumnPanel>,
    pub links: Vec<PanelLink>,
    /// For each panel and each pair of its links the block that the pair updates.
    pub targets: Vec<u32>,
    pub loads: Vec<BlockCopy>,
    /// Blocks that are zero in the matrix: first value and number of values.
    pub fills: Vec<(usize, usize)>,
    /// Number of values in the factors.
    pub len: usize,
    /// Floating point operations of a factorisation.
    pub flops: f64,
    /// Estimated nanoseconds for these, if both halves are used.
    busy: f64,
    pub symmetry: MatrixSymmetry,
}

impl Symbolic {
    /// Finds order and structure; fails if there are more than `max_updates` block updates.
    pub fn new(
        pattern: &BlockPattern,
        symmetry: MatrixSymmetry,
        max_updates: usize,
    ) -> Result<Self, LinearError> {
        let elimination = ordering::minimum_degree(pattern, max_updates)?;
        let mut position = vec![usize::MAX; pattern.blocks()];
        let mut nodes = Vec::new();
        for (&node, later) in elimination.order.iter().zip(&elimination.later) {
            let node = node as usize;
            if pattern.size(node) > 0 {
                position[node] = nodes.len();
                nodes.push((node, later));
            }
        }
        let mut this = Self {
            panels: Vec::with_capacity(nodes.len()),
            links: Vec::new(),
            targets: Vec::new(),
            loads: Vec::new(),
            fills: Vec::new(),
            len: 0,
            flops: 0.0,
            busy: 0.0,
            symmetry,
        };
        this.position(pattern, &nodes, &position);
        this.schedule(pattern, &nodes)?;
        Ok(this)
    }

    /// Panels and links.
    fn position(
        &mut self,
        pattern: &BlockPattern,
        nodes: &[(usize, &Vec<u32>)],
        position: &[usize],
    ) {
        let mut first = 0;
        let mut firsts = Vec::with_capacity(nodes.len());
        for &(node, _) in nodes {
            firsts.push(first);
            first += pattern.size(node);
        }
        for (k, &(node, later)) in nodes.iter().enumerate() {
            let size = pattern.size(node);
            let start = self.len;
            self.len += size * size;
            let mut panels: Vec<usize> = later.iter().map(|&i| position[i as usize]).collect();
            panels.sort_unstable();
            let mut height = 0;
            for panel in panels {
                let m = pattern.size(nodes[panel].0);
                self.links.push(PanelLink {
                    panel,
                    first: firsts[panel],
                    size: m,
                    start: self.len,
                });
                self.len += 2 * m * size;
                height += m;
            }
            let operations = operations(size as f64, height as f64);
            self.flops += operations;
            self.busy += operations / rate(size);
            self.panels.push(ColumnPanel {
                unknown: pattern.unknowns(node).start,
                first: firsts[k],
                size,
                start,
                end: self.len,
                blocks: pattern.column(node).count(),
                links: self.links.len(),
                targets: 0,
                loads: 0,
                fills: 0,
            });
        }
    }

    /// Targets of the updates, and which blocks are first needed when.
    fn schedule(
        &mut self,
        pattern: &BlockPattern,
        nodes: &[(usize, &Vec<u32>)],
    ) -> Result<(), LinearError> {
        if u32::try_from(self.len).is_err() {
            return Err(LinearError::Fill {
                limit: u32::MAX as usize,
            });
        }
        let mut diagonal_done = vec![false; self.panels.len()];
        let mut link_done = vec![false; self.links.len()];
        let mut needed = Vec::new();
        for k in 0..self.panels.len() {
            let range = self.links_of(k);
            // Diagonal blocks come first: the scales of their unknowns are read from them.
            for i in std::iter::once(k).chain(range.clone().map(|l| self.links[l].panel)) {
                if !std::mem::replace(&mut diagonal_done[i], true) {
                    let lower = pattern.find(nodes[i].0, nodes[i].0).unwrap_or(0);
                    self.loads.push(BlockCopy {
                        row: i,
                        column: i,
                        lower,
                        upper: lower,
                        start: self.panels[i].start,
                    });
                }
            }
            needed.clear();
            needed.extend(range.clone().map(|l| (k, l)));
            for a in range.clone() {
                for b in range.clone() {
                    needed.extend(self.add_target(self.links[a].panel, self.links[b].panel));
                }
            }
            for &(column, l) in &needed {
                if !std::mem::replace(&mut link_done[l], true) {
                    self.add_link_load(pattern, nodes, column, l);
                }
            }
            let panel = &mut self.panels[k];
            panel.targets = self.targets.len();
            panel.loads = self.loads.len();
            panel.fills = self.fills.len();
        }
        Ok(())
    }

    /// Adds the target of an update of block (i, j); its panel and link, unless it is diagonal.
    fn add_target(&mut self, i: usize, j: usize) -> Option<(usize, usize)> {
        if i == j {
            self.targets.push(self.panels[i].start as u32);
            return None;
        }
        let (column, row) = (i.min(j), i.max(j));
        let candidates = self.links_of(column);
        let links = &self.links[candidates.clone()];
        // Always found: neighbours of an eliminated node are joined.
        let found = links.binary_search_by_key(&row, |link| link.panel).ok()?;
        let link = &links[found];
        let upper = link.size * self.panels[column].size;
        let start = link.start + if i < j { upper } else { 0 };
        self.targets.push(start as u32);
        Some((column, candidates.start + found))
    }

    /// Adds the blocks of link `l` of panel `column` to the loads, or to the fills if they are zero
    /// in the matrix.
    fn add_link_load(
        &mut self,
        pattern: &BlockPattern,
        nodes: &[(usize, &Vec<u32>)],
        column: usize,
        l: usize,
    ) {
        let link = &self.links[l];
        let (i, j) = (nodes[link.panel].0, nodes[column].0);
        match (pattern.find(i, j), pattern.find(j, i)) {
            (Some(lower), Some(upper)) => self.loads.push(BlockCopy {
                row: link.panel,
                column,
                lower,
                upper,
                start: link.start,
            }),
            _ => {
                let values = 2 * link.size * self.panels[column].size;
                self.fills.push((link.start, values));
            }
        }
    }

    /// Estimated time of a factorisation.
    pub fn nanoseconds(&self) -> f64 {
        let operations = match self.symmetry {
            MatrixSymmetry::General => self.busy,
            MatrixSymmetry::Symmetric => 0.55 * self.busy,
        };
        150.0 * self.panels.len() as f64 + 10.0 * self.targets.len() as f64 + operations
    }

    /// Indices of a panel's links.
    pub fn links_of(&self, k: usize) -> Range<usize> {
        self.span(k, |panel| panel.links)
    }

    /// Indices of a panel in the list in which its entries end at `end`.
    #[inline(always)]
    pub fn span(&self, k: usize, end: impl Fn(&ColumnPanel) -> usize) -> Range<usize> {
        let start = if k == 0 { 0 } else { end(&self.panels[k - 1]) };
        start..end(&self.panels[k])
    }
}

/// Operations per nanosecond with the kernels for blocks of one size.
fn rate(n: usize) -> f64 {
    match n {
        6 => 9.0,
        3 => 4.0,
        _ => 2.0,
    }
}

/// Operations of one elimination step: `n` pivots, `m` later unknowns.
fn operations(n: f64, m: f64) -> f64 {
    2.0 / 3.0 * n * n * n + 2.0 * n * n * m + 2.0 * n * m * m
}
