//! Dependencies of mapped nodes on own nodes, and the order of evaluation.

use super::{ModelError, Node, Source};
use crate::memory;

/// For every node, all sets of own nodes that it can depend on: one for each combination of
/// segments, each ascending and without repetition.
pub(super) struct Alternatives(Vec<Vec<Vec<u32>>>);

impl Alternatives {
    /// The sets of all nodes; `order` lists mapped nodes, parents first.
    ///
    /// # Errors
    /// [`ModelError::Chain`] if there is not enough memory for all dependencies.
    pub(super) fn new(nodes: &[Node], order: &[u32]) -> Result<Self, ModelError> {
        let own = |(n, node): (usize, &Node)| match node.source {
            Source::Own => vec![vec![n as u32]],
            Source::Mapped(_) => Vec::new(),
        };
        let mut all = Self(nodes.iter().enumerate().map(own).collect());
        let mut coordinates = 0.0;
        for &n in order {
            if let Source::Mapped(d) = &nodes[n as usize].source {
                let mut sets: Vec<Vec<u32>> = d.segments.iter().flat_map(|s| all.of(s)).collect();
                sets.sort_unstable();
                sets.dedup();
                let behind = sets.iter().flatten().map(|&m| nodes[m as usize].dim);
                coordinates += behind.sum::<usize>() as f64;
                memory::followed(coordinates).map_err(|[needs, free]| ModelError::Chain {
                    node: nodes[n as usize].name.clone(),
                    needs,
                    free,
                })?;
                all.0[n as usize] = sets;
            }
        }
        Ok(all)
    }

    /// All sets of own nodes that a group of nodes can depend on.
    pub(super) fn of(&self, group: &[u32]) -> Vec<Vec<u32>> {
        let mut sets = vec![Vec::new()];
        for &n in group {
            let behind = &self.0[n as usize];
            sets = (sets.iter())
                .flat_map(|set| behind.iter().map(|more| union(set, more)))
                .collect();
        }
        sets
    }

    /// All own nodes that a group of nodes can depend on, ascending.
    pub(super) fn behind(&self, group: &[u32]) -> Vec<u32> {
        let sets = group.iter().flat_map(|&n| &self.0[n as usize]);
        sets.fold(Vec::new(), |all, set| union(&all, set))
    }
}

/// The union of two ascending lists.
pub(super) fn union(a: &[u32], b: &[u32]) -> Vec<u32> {
    let mut out = Vec::with_capacity(a.len() + b.len());
    let (mut i, mut j) = (0, 0);
    while i < a.len() || j < b.len() {
        let next = match (a.get(i), b.get(j)) {
            (Some(&x), Some(&y)) => x.min(y),
            (Some(&x), None) | (None, Some(&x)) => x,
            (None, None) => break,
        };
        i += usize::from(a.get(i) == Some(&next));
        j += usize::from(b.get(j) == Some(&next));
        out.push(next);
    }
    out
}

/// Mapped nodes, parents first.
pub(super) fn order(nodes: &[Node]) -> Vec<u32> {
    let (mut done, mut out) = (vec![false; nodes.len()], Vec::new());
    // The nodes to visit, and whether their parents were visited; not recursive, as chains may be
    // long.
    let mut waiting: Vec<(u32, bool)> = Vec::new();
    for n in 0..nodes.len() as u32 {
        waiting.push((n, false));
        while let Some((n, behind)) = waiting.pop() {
            if behind {
                out.push(n);
                continue;
            }
            if std::mem::replace(&mut done[n as usize], true) {
                continue;
            }
            if let Source::Mapped(d) = &nodes[n as usize].source {
                waiting.push((n, true));
                let parents = d.segments.iter().flatten().rev();
                waiting.extend(parents.map(|&m| (m, false)));
            }
        }
    }
    out
}

/// Finds ancestors and assigns space for operators; returns the number of values.
pub(super) fn arrange(nodes: &mut [Node], order: &[u32], alternatives: &Alternatives) -> usize {
    let mut len = 0;
    for n in order.iter().map(|&n| n as usize) {
        let Source::Mapped(d) = &nodes[n].source else {
            continue;
        };
        let size = |set: &Vec<u32>| -> usize { set.iter().map(|&n| nodes[n as usize].dim).sum() };
        let sets = &alternatives.0[n];
        let most = sets.iter().map(size).max().unwrap_or(0);
        let longest = |n: usize| alternatives.0[n].iter().map(Vec::len).max().unwrap_or(0);
        let entries = |s: &Vec<u32>| -> usize { s.iter().map(|&m| longest(m as usize)).sum() };
        let entries = d.segments.iter().map(entries).max().unwrap_or(0);
        let repeats = |s: &Vec<u32>| (1..s.len()).any(|k| s[..k].contains(&s[k]));
        let chained = d.segments.iter().any(|s| {
            let follows = |m: &u32| !nodes[*m as usize].is_own();
            s.iter().any(follows) || repeats(s)
        });
        let (longest, dim) = (longest(n), nodes[n].dim);
        if let Source::Mapped(d) = &mut nodes[n].source {
            (d.chained, d.local) = (chained, len);
            d.ancestors = Vec::with_capacity(longest);
            d.columns = Vec::with_capacity(entries);
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

/// Own nodes behind the parents in use, each once, and the columns of every parent's own nodes in
/// the operators. Parents come before the nodes mapped from them.
pub(super) fn find_ancestors(nodes: &mut [Node], n: usize) {
    let Source::Mapped(d) = &mut nodes[n].source else {
        return;
    };
    let mut ancestors = std::mem::take(&mut d.ancestors);
    let mut columns = std::mem::take(&mut d.columns);
    ancestors.clear();
    columns.clear();
    let Source::Mapped(d) = &nodes[n].source else {
        return;
    };
    let dim = |m: u32| nodes[m as usize].dim;
    let mut pulled = 0;
    for m in d.parents() {
        let behind = match &nodes[*m as usize].source {
            Source::Own => std::slice::from_ref(m),
            Source::Mapped(above) => &above.ancestors[..],
        };
        // The ancestors of one parent are all different.
        let before = ancestors.len();
        for &a in behind {
            let known = ancestors[..before].iter().position(|&x| x == a);
            if let Some(k) = known {
                let first: usize = ancestors[..k].iter().map(|&x| dim(x)).sum();
                columns.push(first as u32);
            } else {
                columns.push(pulled as u32);
                ancestors.push(a);
                pulled += dim(a);
            }
        }
    }
    if let Source::Mapped(d) = &mut nodes[n].source {
        (d.ancestors, d.columns, d.pulled) = (ancestors, columns, pulled);
    }
}
