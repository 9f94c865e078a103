//! On which own nodes the nodes that follow others depend, and in which order they follow.

use super::{Node, Source};

/// All sets of own nodes that a group of nodes can depend on: one for each combination of
/// segments.
pub(super) fn alternatives(nodes: &[Node], group: &[u32]) -> Vec<Vec<u32>> {
    let mut sets = vec![Vec::new()];
    for &n in group {
        let behind = match &nodes[n as usize].source {
            Source::Own => vec![vec![n]],
            Source::Mapped(d) => d
                .segments
                .iter()
                .flat_map(|masters| alternatives(nodes, masters))
                .collect(),
        };
        sets = sets
            .iter()
            .flat_map(|set| behind.iter().map(|more| [&set[..], more].concat()))
            .collect();
    }
    sets
}

/// Nodes that follow others, masters first.
pub(super) fn order(nodes: &[Node]) -> Vec<u32> {
    fn visit(nodes: &[Node], n: u32, done: &mut [bool], out: &mut Vec<u32>) {
        if std::mem::replace(&mut done[n as usize], true) {
            return;
        }
        if let Source::Mapped(d) = &nodes[n as usize].source {
            for &m in d.segments.iter().flatten() {
                visit(nodes, m, done, out);
            }
            out.push(n);
        }
    }
    let (mut done, mut out) = (vec![false; nodes.len()], Vec::new());
    for n in 0..nodes.len() as u32 {
        visit(nodes, n, &mut done, &mut out);
    }
    out
}

/// Finds ancestors and reserves room for operators; the number of values needed.
pub(super) fn arrange(nodes: &mut [Node], order: &[u32]) -> usize {
    let mut len = 0;
    for n in order.iter().map(|&n| n as usize) {
        let Source::Mapped(d) = &nodes[n].source else {
            continue;
        };
        let size = |set: &Vec<u32>| -> usize { set.iter().map(|&n| nodes[n as usize].dim).sum() };
        let sets = alternatives(nodes, &[n as u32]);
        let most = sets.iter().map(size).max().unwrap_or(0);
        let longest = sets.iter().map(Vec::len).max().unwrap_or(0);
        let chained = d
            .segments
            .iter()
            .flatten()
            .any(|&m| !nodes[m as usize].is_own());
        let dim = nodes[n].dim;
        if let Source::Mapped(d) = &mut nodes[n].source {
            (d.most, d.chained, d.local) = (most, chained, len);
            d.ancestors = Vec::with_capacity(longest);
            len += dim * d.direct;
            d.total = d.local;
            if chained {
                d.total = len;
                len += dim * most;
            }
        }
    }
    for &n in order {
        find_ancestors(nodes, n as usize);
    }
    len
}

/// Own nodes behind the masters in use. Masters come before the nodes that follow them.
pub(super) fn find_ancestors(nodes: &mut [Node], n: usize) {
    let Source::Mapped(d) = &mut nodes[n].source else {
        return;
    };
    let mut ancestors = std::mem::take(&mut d.ancestors);
    ancestors.clear();
    let Source::Mapped(d) = &nodes[n].source else {
        return;
    };
    for &m in d.masters() {
        match &nodes[m as usize].source {
            Source::Own => ancestors.push(m),
            Source::Mapped(above) => ancestors.extend(&above.ancestors),
        }
    }
    let pulled = ancestors.iter().map(|&m| nodes[m as usize].dim).sum();
    if let Source::Mapped(d) = &mut nodes[n].source {
        (d.ancestors, d.pulled) = (ancestors, pulled);
    }
}
