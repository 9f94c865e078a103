//! Nodes that tangents couple with mapped nodes, and the positions of these tangents.

use crate::model::kinematics::mapped_node::MappedNode;
use crate::model::{ElementEntry, NONE, Node, Source};

/// The nodes coupled with a mapped node before it is pulled back to its parents: those of its elements,
/// and of all that depends on it. Each block is K, C and M, one after the other.
#[derive(Clone, Default)]
pub(in crate::model) struct Coupled {
    /// Own nodes, and mapped nodes that are pulled back later, ascending.
    pub partners: Vec<Partner>,
    /// Whether an element can exert a force on it, and an unknown moves it.
    pub loaded: bool,
    /// First value of its own block.
    pub diagonal: usize,
    /// First of the positions at its parents.
    pub first_position: usize,
}

/// A node coupled with a mapped one.
#[derive(Clone, Copy)]
pub(in crate::model) struct Partner {
    pub node: u32,
    /// First value of the mapped node's rows and the partner's columns, and of the transposed block.
    pub row: usize,
    pub column: usize,
}

/// The couplings of all mapped nodes, by [`MappedNode::index`], and the nodes that no unknown moves.
#[derive(Clone, Default)]
pub(in crate::model) struct Couplings(pub(in crate::model) Vec<Coupled>, Vec<bool>);

impl Couplings {
    /// Finds all couplings by elements, and by maps with the parents of the given segments; returns the
    /// number of values of all blocks. Fixed nodes, without a block in the pattern, have none.
    pub(in crate::model) fn find<'a>(
        &mut self,
        nodes: &'a [Node],
        dependent: &[u32],
        elements: &[ElementEntry],
        blocks: &[u32],
        segments: impl Fn(&'a MappedNode) -> &'a [Vec<u32>],
    ) -> usize {
        self.0.resize_with(dependent.len(), Coupled::default);
        let held = nodes
            .iter()
            .zip(blocks)
            .map(|(n, &block)| n.is_own() && block == NONE);
        self.1.clear();
        self.1.extend(held);
        for &n in dependent {
            if let Source::Mapped(d) = &nodes[n as usize].source {
                let mut parents = segments(d).iter().flatten();
                self.1[n as usize] = parents.all(|&m| self.1[m as usize]);
            }
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
        for &n in dependent.iter().rev() {
            let Source::Mapped(d) = &nodes[n as usize].source else {
                continue;
            };
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
        self.arrange(nodes, dependent)
    }

    /// Arranges the blocks, those of parents first; returns the number of their values.
    fn arrange(&mut self, nodes: &[Node], dependent: &[u32]) -> usize {
        let mut len = 0;
        for (coupled, &n) in self.0.iter_mut().zip(dependent) {
            if !coupled.loaded {
                continue;
            }
            let dim = nodes[n as usize].dim;
            coupled.diagonal = len;
            len += 3 * dim * dim;
            for partner in &mut coupled.partners {
                let other = &nodes[partner.node as usize];
                let size = dim * other.dim;
                partner.row = len;
                partner.column = len + 3 * size;
                len = partner.column + 3 * size;
            }
        }
        len
    }

    fn load(&mut self, nodes: &[Node], group: &[u32]) {
        for &n in group {
            if let Source::Mapped(d) = &nodes[n as usize].source {
                self.0[d.index].loaded |= !self.1[n as usize];
            }
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
                    let (row, column) = (0, 0);
                    partners.insert(at, Partner { node, row, column });
                }
            }
        }
    }

    /// Whether no unknown moves a node.
    pub(in crate::model) fn is_fixed(&self, n: u32) -> bool {
        self.1[n as usize]
    }

    /// First value of the rows of node `i` and the columns of node `j`, one of them mapped; `None` if
    /// they are not coupled.
    pub(in crate::model) fn position(&self, nodes: &[Node], i: u32, j: u32) -> Option<usize> {
        let (owner, partner) = owner(nodes, i, j)?;
        let coupled = &self.0[owner];
        if i == j {
            return coupled.loaded.then_some(coupled.diagonal);
        }
        let found = coupled.partners.binary_search_by_key(&partner, |p| p.node);
        let found = &coupled.partners[found.ok()?];
        Some(if partner == j {
            found.row
        } else {
            found.column
        })
    }
}

/// Index of the node of a pair that is pulled back first, and the other node; `None` if both are own.
fn owner(nodes: &[Node], i: u32, j: u32) -> Option<(usize, u32)> {
    match [i, j].map(|n| &nodes[n as usize].source) {
        [Source::Own, Source::Own] => None,
        [Source::Mapped(a), Source::Mapped(b)] if a.index < b.index => Some((b.index, i)),
        [Source::Mapped(a), _] => Some((a.index, j)),
        [Source::Own, Source::Mapped(b)] => Some((b.index, i)),
    }
}
