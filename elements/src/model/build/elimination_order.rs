//! The order in which nodes are numbered, and eliminated from the last to the first.

use crate::model::{ElementEntry, Node, Prescribed};

/// All nodes by their distance from the supports, counted in elements.
///
/// Elimination takes the last first: from free ends towards supports every partial structure is
/// held by the rest, and pivots keep their size. In the opposite order the last pivot of a
/// cantilever would be its tip stiffness, small by the cube of the number of elements.
pub(in crate::model) fn outward(
    nodes: &[Node],
    elements: &[ElementEntry],
    prescribed: &[Prescribed],
) -> Vec<usize> {
    let mut touching: Vec<Vec<usize>> = vec![Vec::new(); nodes.len()];
    let mut groups: Vec<Vec<usize>> = Vec::with_capacity(elements.len());
    let indices = |nodes: &[u32]| nodes.iter().map(|&n| n as usize).collect::<Vec<_>>();
    groups.extend(elements.iter().map(|e| indices(&e.nodes)));
    for (n, node) in nodes.iter().enumerate() {
        if let Some(d) = node.mapped() {
            for parents in &d.segments {
                groups.push(indices(parents));
                groups.last_mut().into_iter().for_each(|g| g.push(n));
            }
        }
    }
    for (g, group) in groups.iter().enumerate() {
        for &n in group {
            touching[n].push(g);
        }
    }
    let mut coordinate_node = Vec::new();
    for (n, node) in nodes.iter().enumerate() {
        coordinate_node.extend(std::iter::repeat_n(n, node.dim));
    }
    let mut reached = vec![false; nodes.len()];
    let mut used = vec![false; groups.len()];
    let mut order: Vec<usize> = Vec::with_capacity(nodes.len());
    let mut next = 0;
    let held = prescribed.iter().map(|p| coordinate_node[p.coordinate]);
    for n in held {
        if !std::mem::replace(&mut reached[n], true) {
            order.push(n);
        }
    }
    for seed in 0..=nodes.len() {
        while next < order.len() {
            for &g in &touching[order[next]] {
                if std::mem::replace(&mut used[g], true) {
                    continue;
                }
                for &m in &groups[g] {
                    if !std::mem::replace(&mut reached[m], true) {
                        order.push(m);
                    }
                }
            }
            next += 1;
        }
        // Parts without a support follow, each from its first node.
        if seed < nodes.len() && !reached[seed] {
            reached[seed] = true;
            order.push(seed);
        }
    }
    order
}
