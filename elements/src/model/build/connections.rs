//! Check that every node of a model is connected to something.

use crate::model::loops::Closing;
use crate::model::{ElementEntry, ModelError, Node, Nodes, Prescribed, Subject};
use std::collections::HashSet;

/// Every own node must have an element that is not a load, directly or through a joint; a mapped
/// node, which has no coordinates of its own, may be unused, as a point for output. A node that is
/// held or prescribed as a whole only needs a joint, or a loop that ends there.
pub(in crate::model) fn check_connections(
    nodes: &Nodes,
    elements: &[ElementEntry],
    closings: &[Closing],
    prescribed: &[Prescribed],
) -> Result<(), ModelError> {
    let mut connected = vec![false; nodes.len()];
    for e in elements {
        for &n in e.nodes.iter() {
            connected[n as usize] |= !e.load;
        }
    }
    // From the end of a chain to its beginning.
    for (n, node, _) in nodes.mapped().rev() {
        if connected[n as usize] {
            for m in node.all_parents() {
                connected[m as usize] = true;
            }
        }
    }
    let held: HashSet<usize> = prescribed.iter().map(|p| p.coordinate).collect();
    let ends = closings.iter().flat_map(|c| [c.frame.0, c.child.0]);
    let parents = nodes.iter().flat_map(Node::all_parents);
    for n in ends.chain(parents).map(|n| n as usize) {
        connected[n] |= nodes[n].range().all(|c| held.contains(&c));
    }
    let alone = |(node, connected): (&Node, &bool)| node.is_own() && !connected;
    match nodes.iter().zip(&connected).position(alone) {
        None => Ok(()),
        Some(n) => Err(ModelError::Unconnected {
            node: Subject::node(nodes, n as u32),
        }),
    }
}
