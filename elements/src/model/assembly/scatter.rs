//! Tangents of elements with mapped nodes.

use crate::model::assembly::scatter_map::ScatterMap;
use crate::model::{ElementEntry, Node};
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
        let pieces = self.pieces[self.first_positions[k]..].chunks_exact(e.nodes.len());
        let mut column = 0;
        for (pieces, &node) in pieces.zip(e.nodes.iter()) {
            for c in 0..nodes[node as usize].dim {
                for piece in pieces {
                    let of_orders = tangents.iter().map(|T| &T[column * d..]);
                    piece.add(of_orders, c, &self.rows, into);
                }
                column += 1;
            }
        }
    }
}
