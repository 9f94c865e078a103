//! Tangents of elements with mapped nodes.

#![allow(non_snake_case)]

use crate::model::assembly::scatter_map::{ScatterMap, free_part};
use crate::model::kinematics::node_entries::add;
use crate::model::{ElementEntry, NONE, Node};
use pullback_manifold::system::Weights;
use std::ops::Range;

/// Destination of a scatter.
pub(in crate::model) struct ScatterTarget<'a> {
    /// Values of the pattern, and of the blocks of mapped nodes.
    pub values: &'a mut [f64],
    pub coupled: &'a mut [f64],
    /// Which of K, C and M there are, and the factors of these: the pattern holds the weighted sum
    /// cK K + cC C + cM M.
    pub needed: Range<usize>,
    pub weights: [f64; 3],
}

impl<'a> ScatterTarget<'a> {
    pub(in crate::model) fn new(
        values: &'a mut [f64],
        coupled: &'a mut [f64],
        weights: &Weights,
        at_rest: bool,
    ) -> Self {
        let needed = weights.needed(at_rest);
        let mut of_needed = [0.0; 3];
        let all = [weights.K, weights.C, weights.M];
        of_needed[..needed.len()].copy_from_slice(&all[needed.clone()]);
        Self {
            values,
            coupled,
            needed,
            weights: of_needed,
        }
    }
}

impl ScatterMap {
    /// Adds the needed ones of the tangents K, C and M of element `k`, which has mapped nodes.
    pub(in crate::model) fn scatter_mapped(
        &self,
        k: usize,
        e: &ElementEntry,
        nodes: &[Node],
        tangents: [&[f64]; 3],
        into: &mut ScatterTarget<'_>,
    ) {
        let (d, tangents) = (e.element.dim(), &tangents[into.needed.clone()]);
        let mut positions = self.positions[self.first_position(k)..].iter();
        let mut column = 0;
        for &j in e.nodes.iter() {
            let columns = &nodes[j as usize];
            let mut row = 0;
            for (&i, position) in e.nodes.iter().zip(&mut positions) {
                let rows = &nodes[i as usize];
                let from = row + column * d;
                row += rows.dim;
                if position.start == NONE {
                    continue;
                }
                if rows.is_own() && columns.is_own() {
                    let block = (&self.rows[rows.range()], &self.rows[columns.range()]);
                    for (order, tangent) in tangents.iter().enumerate() {
                        let first = position.first && order == 0;
                        let values = &mut into.values[position.start as usize..];
                        let (from, weight) = ((&tangent[from..], d), into.weights[order]);
                        free_part(block, from, weight, values, first);
                    }
                    continue;
                }
                let Some(block) = self.couplings.block(nodes, i, j) else {
                    continue;
                };
                for (order, tangent) in tangents.iter().enumerate() {
                    let to = &mut into.coupled[block.start + order * block.order..];
                    for (c, from) in tangent[from..].chunks(d).take(columns.dim).enumerate() {
                        let to = &mut to[c * block.column..];
                        if block.row == 1 {
                            add(&mut to[..rows.dim], &from[..rows.dim], 1.0);
                            continue;
                        }
                        for (r, s) in from[..rows.dim].iter().enumerate() {
                            to[r * block.row] += s;
                        }
                    }
                }
            }
            column += columns.dim;
        }
    }
}
