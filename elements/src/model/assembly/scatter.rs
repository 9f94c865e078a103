//! Scattering of tangents of groups with mapped nodes to the pattern.
//!
//! ```text
//! rows of own nodes     →  pattern
//! rows of mapped nodes  →  panels  →  Bᵀ  →  panels of their parents, pattern
//! ```

#![allow(non_snake_case)]

use crate::model::assembly::scatter_map::{BlockPosition, ScatterMap};
use crate::model::kinematics::mapped_node::{Maps, Operators};
use crate::model::{NONE, Node, Source};
use pullback_manifold::pullback::{self, Slot, Tangents};
use pullback_manifold::system::Weights;

/// Tangents over the coordinates of a group of nodes.
pub(in crate::model) struct Group<'a> {
    pub nodes: &'a [u32],
    pub first_position: usize,
    pub tangents: Tangents<'a>,
    pub weights: Weights,
}

/// Destination of a scatter, and scratch for a column.
pub(in crate::model) struct ScatterTarget<'a> {
    pub values: &'a mut [f64],
    pub panels: &'a mut [f64],
    pub work: &'a mut [f64],
}

impl ScatterMap {
    /// Adds the pulled-back tangents of a group of nodes, (cK K + cC C + cM M, B) column by column:
    /// rows of own nodes to the pattern, those of mapped nodes to their panels.
    pub(in crate::model) fn scatter_group(
        &self,
        nodes: &[Node],
        operators: &Operators,
        group: &Group<'_>,
        into: &mut ScatterTarget<'_>,
    ) {
        let n = group.nodes.iter().map(|&i| nodes[i as usize].dim).sum();
        let (tangents, weights) = (group.tangents, group.weights);
        let mut positions =
            self.positions[group.first_position..].chunks_exact(group.nodes.len().max(1));
        let mut x = 0;
        for j in group.nodes {
            let node = &nodes[*j as usize];
            let slot = match &node.source {
                Source::Own => Slot::default(),
                Source::Mapped(d) => operators.slot(node.dim, d.total),
            };
            let mut column_of_node = 0;
            for (&a, positions) in (self.dependencies.behind(nodes, j).iter()).zip(&mut positions) {
                for &column in &self.rows[nodes[a as usize].range()] {
                    let c = column_of_node;
                    column_of_node += 1;
                    if column == NONE {
                        continue;
                    }
                    let work = &mut into.work[..n];
                    pullback::pulled_column(work, tangents, weights, x, &slot, c);
                    self.put(nodes, group.nodes, positions, column as usize, into);
                }
            }
            x += node.dim;
        }
    }

    /// Adds a column at its positions, node by node.
    fn put(
        &self,
        nodes: &[Node],
        group: &[u32],
        positions: &[BlockPosition],
        column: usize,
        into: &mut ScatterTarget<'_>,
    ) {
        let mut rest = &*into.work;
        for (&i, position) in group.iter().zip(positions) {
            let node = &nodes[i as usize];
            let (S, others) = rest.split_at(node.dim);
            rest = others;
            if position.start == NONE {
                continue;
            }
            if !node.is_own() {
                let to = &mut into.panels[position.start as usize + column * node.dim..];
                to.iter_mut().zip(S).for_each(|(value, s)| *value += s);
                continue;
            }
            let to = &mut into.values[position.start as usize + column * self.width(node)..];
            for (&row, s) in self.rows[node.range()].iter().zip(S) {
                if row != NONE {
                    let value = &mut to[row as usize];
                    *value = if position.first { *s } else { *value + s };
                }
            }
        }
    }

    /// Adds the rows at a mapped node to its parents: Bᵀ times its panel.
    pub(in crate::model) fn pull_back_rows(
        &self,
        n: u32,
        nodes: &[Node],
        maps: &Maps,
        operators: &Operators,
        into: &mut ScatterTarget<'_>,
    ) {
        let (panel, node) = (&self.panels[n as usize], &nodes[n as usize]);
        let (Source::Mapped(d), Some(&start)) = (&node.source, panel.starts.first()) else {
            return;
        };
        // Panels of parents come before those of the nodes mapped from them.
        let (above, own) = into.panels.split_at_mut(start as usize);
        let mut columns = own.chunks_exact(node.dim);
        let parents = d.parents(maps);
        let positions = self.positions[panel.parent_rows..].chunks_exact(parents.len().max(1));
        for (&a, positions) in panel.columns.iter().zip(positions) {
            for column in 0..self.width(&nodes[a as usize]) {
                let Some(f) = columns.next() else { return };
                if f.iter().all(|f| *f == 0.0) {
                    continue;
                }
                let mut pulled = pullback::transposed(&operators.B[d.local..], f);
                for (&m, position) in parents.iter().zip(positions) {
                    let parent = &nodes[m as usize];
                    let S = pulled.by_ref().take(parent.dim);
                    let start = position.start as usize;
                    if position.start == NONE {
                        S.for_each(drop);
                    } else if parent.is_own() {
                        let to = &mut into.values[start + column * self.width(parent)..];
                        for (&row, s) in self.rows[parent.range()].iter().zip(S) {
                            if row != NONE {
                                to[row as usize] += s;
                            }
                        }
                    } else {
                        let to = &mut above[start + column * parent.dim..];
                        to.iter_mut().zip(S).for_each(|(value, s)| *value += s);
                    }
                }
            }
        }
    }
}
