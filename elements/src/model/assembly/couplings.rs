//! Nodes that tangents couple with mapped nodes, and the positions of these tangents.

use crate::model::kinematics::mapped_node::MappedNode;
use crate::model::{ElementEntry, NONE, Node, Nodes};

/// The nodes coupled with a mapped node before it is pulled back to its parents: those of its elements,
/// and of all that depends on it.
///
/// Its tangents are three matrices by columns, each for K, C and M: its own block, n×n; its rows at the
/// coordinates of all partners, n×`width`; and the transpose of its columns there.
#[derive(Clone, Default)]
pub(in crate::model) struct Coupled {
    /// Own nodes, and mapped nodes that are pulled back later, ascending.
    pub partners: Vec<Partner>,
    /// Number of coordinates of all partners.
    pub width: usize,
    /// Whether an element can exert a force on it, and an unknown moves it.
    pub loaded: bool,
    /// First value of its own block, of its rows and of its columns.
    pub own: usize,
    pub rows: usize,
    pub columns: usize,
    /// Number of its first piece, and of the coordinates of each parent.
    pub first_piece: usize,
    pub parents: Vec<usize>,
}

/// A node coupled with a mapped one: the first of its coordinates among those of all partners, and their number.
#[derive(Clone, Copy)]
pub(in crate::model) struct Partner {
    pub node: u32,
    pub first: usize,
    pub dim: usize,
}

/// The position of a block among the tangents of mapped nodes: its first value, and the distances between
/// rows, between columns, and between K, C and M.
#[derive(Clone, Copy)]
pub(in crate::model) struct CoupledBlock {
    pub start: usize,
    pub row: usize,
    pub column: usize,
    pub order: usize,
}

impl CoupledBlock {
    /// Its rows as columns.
    pub(in crate::model) fn transposed(self) -> Self {
        let (row, column) = (self.column, self.row);
        Self {
            row,
            column,
            ..self
        }
    }
}

/// The couplings of all mapped nodes, by [`MappedNode::index`], and the nodes that no unknown moves.
#[derive(Clone, Default)]
pub(in crate::model) struct Couplings(pub(in crate::model) Vec<Coupled>, Vec<bool>);

impl Couplings {
    /// Finds all couplings by elements, and by maps with the parents of the given segments; returns the
    /// number of values of all blocks. Fixed nodes, without a block in the pattern, have none.
    pub(in crate::model) fn find<'a>(
        &mut self,
        nodes: &'a Nodes,
        elements: &[ElementEntry],
        blocks: &[u32],
        segments: impl Fn(&'a MappedNode) -> &'a [Vec<u32>],
    ) -> usize {
        self.0.resize_with(nodes.mapped.len(), Coupled::default);
        let held = nodes
            .iter()
            .zip(blocks)
            .map(|(n, &block)| n.is_own() && block == NONE);
        self.1.clear();
        self.1.extend(held);
        for (n, _, d) in nodes.mapped() {
            let mut parents = segments(d).iter().flatten();
            self.1[n as usize] = parents.all(|&m| self.1[m as usize]);
        }
        for coupled in &mut self.0 {
            coupled.partners.clear();
            coupled.loaded = false;
        }
        for e in elements.iter().filter(|e| e.mapped) {
            self.load(nodes, &e.nodes);
            if !e.dead {
                self.couple(nodes, &e.nodes);
            }
        }
        for (_, _, d) in nodes.mapped().rev() {
            if !self.0[d.index].loaded {
                continue;
            }
            let partners = std::mem::take(&mut self.0[d.index].partners);
            for parents in segments(d) {
                self.load(nodes, parents);
                self.couple(nodes, parents);
                for (&p, partner) in
                    (parents.iter()).flat_map(|p| partners.iter().map(move |partner| (p, partner)))
                {
                    self.couple(nodes, &[p, partner.node]);
                }
            }
            self.0[d.index].partners = partners;
        }
        self.arrange(nodes)
    }

    /// Arranges the tangents, those of parents first; returns the number of their values.
    fn arrange(&mut self, nodes: &Nodes) -> usize {
        let mut len = 0;
        for (coupled, (_, node, _)) in self.0.iter_mut().zip(nodes.mapped()) {
            if !coupled.loaded {
                continue;
            }
            coupled.width = 0;
            for partner in &mut coupled.partners {
                partner.first = coupled.width;
                coupled.width += partner.dim;
            }
            let dim = node.dim;
            coupled.own = len;
            coupled.rows = coupled.own + 3 * dim * dim;
            coupled.columns = coupled.rows + 3 * dim * coupled.width;
            len = coupled.columns + 3 * dim * coupled.width;
        }
        len
    }

    fn load(&mut self, nodes: &Nodes, group: &[u32]) {
        for (n, _, d) in nodes.mapped_of(group) {
            self.0[d.index].loaded |= !self.1[n as usize];
        }
    }

    /// Couples each two nodes of a group.
    fn couple(&mut self, nodes: &[Node], group: &[u32]) {
        for (k, &i) in group.iter().enumerate() {
            for &j in &group[..k] {
                if i == j || self.1[i as usize] || self.1[j as usize] {
                    continue;
                }
                let Some((owner, node)) = owner(nodes, i, j) else {
                    continue;
                };
                let partners = &mut self.0[owner].partners;
                if let Err(at) = partners.binary_search_by_key(&node, |p| p.node) {
                    let (first, dim) = (0, nodes[node as usize].dim);
                    partners.insert(at, Partner { node, first, dim });
                }
            }
        }
    }

    /// Whether no unknown moves a node.
    pub(in crate::model) fn is_fixed(&self, n: u32) -> bool {
        self.1[n as usize]
    }

    /// The block with the rows of node `i` and the columns of node `j`, one of them mapped; `None` if they are
    /// not coupled.
    pub(in crate::model) fn block(&self, nodes: &[Node], i: u32, j: u32) -> Option<CoupledBlock> {
        let (owner, partner) = owner(nodes, i, j)?;
        let coupled = &self.0[owner];
        if i == j {
            let n = nodes[i as usize].dim;
            return coupled.loaded.then_some(CoupledBlock {
                start: coupled.own,
                row: 1,
                column: n,
                order: n * n,
            });
        }
        let found = coupled.partners.binary_search_by_key(&partner, |p| p.node);
        let (first, width) = (coupled.partners[found.ok()?].first, coupled.width);
        let is_row = partner == j;
        let (node, start) = match is_row {
            true => (i, coupled.rows),
            false => (j, coupled.columns),
        };
        let n = nodes[node as usize].dim;
        let block = CoupledBlock {
            start: start + first * n,
            row: 1,
            column: n,
            order: n * width,
        };
        Some(if is_row { block } else { block.transposed() })
    }
}

/// Index of the node of a pair that is pulled back first, and the other node; `None` if both are own.
fn owner(nodes: &[Node], i: u32, j: u32) -> Option<(usize, u32)> {
    match [i, j].map(|n| nodes[n as usize].mapped()) {
        [None, None] => None,
        [Some(a), Some(b)] if a.index < b.index => Some((b.index, i)),
        [Some(a), _] => Some((a.index, j)),
        [None, Some(b)] => Some((b.index, i)),
    }
}
