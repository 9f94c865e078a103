//! The order in which nodes are numbered, and eliminated from the last to the first.

use crate::model::{ElementEntry, Nodes, Prescribed};

/// All nodes by their distance from the supports, counted in elements.
///
/// Elimination takes the last first: from free ends towards supports every partial structure is
/// held by the rest, and pivots keep their size. In the opposite order the last pivot of a
/// cantilever would be its tip stiffness, small by the cube of the number of elements.
pub(in crate::model) fn outward(
    nodes: &Nodes,
    elements: &[ElementEntry],
    prescribed: &[Prescribed],
) -> Vec<usize> {
    let mut groups: Vec<Vec<u32>> = elements.iter().map(|e| e.nodes.to_vec()).collect();
    for (n, node) in (0..).zip(nodes.iter()) {
        let segments = node.segments().iter();
        groups.extend(segments.map(|parents| [parents, &[n][..]].concat()));
    }
    let mut touching: Vec<Vec<usize>> = vec![Vec::new(); nodes.len()];
    for (g, group) in groups.iter().enumerate() {
        for &n in group {
            touching[n as usize].push(g);
        }
    }
    let mut reached = vec![false; nodes.len()];
    let mut reach = |n: usize, order: &mut Vec<usize>| {
        if !std::mem::replace(&mut reached[n], true) {
            order.push(n);
        }
    };
    let mut used = vec![false; groups.len()];
    let mut order: Vec<usize> = Vec::with_capacity(nodes.len());
    let mut next = 0;
    for p in prescribed {
        reach(nodes.of_coordinate(p.coordinate), &mut order);
    }
    for seed in 0..=nodes.len() {
        while next < order.len() {
            for &g in &touching[order[next]] {
                if std::mem::replace(&mut used[g], true) {
                    continue;
                }
                for &m in &groups[g] {
                    reach(m as usize, &mut order);
                }
            }
            next += 1;
        }
        // Parts without a support follow, each from its first node.
        if seed < nodes.len() {
            reach(seed, &mut order);
        }
    }
    order
}
