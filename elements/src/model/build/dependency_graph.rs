//! Dependencies of mapped nodes on own nodes, and the order of evaluation.

use crate::memory;
use crate::model::kinematics::mapped_node::Maps;
use crate::model::{ModelError, Node, Source};

/// For every node, all sets of own nodes that it can depend on: one for each combination of
/// segments, each ascending and without repetition.
pub(in crate::model) struct Alternatives(Vec<Vec<Vec<u32>>>);

impl Alternatives {
    /// The sets of all nodes; `order` lists mapped nodes, parents first.
    ///
    /// # Errors
    /// [`ModelError::Chain`] if there is not enough memory for all dependencies.
    pub(in crate::model) fn new(nodes: &[Node], order: &[u32]) -> Result<Self, ModelError> {
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
    pub(in crate::model) fn of(&self, group: &[u32]) -> Vec<Vec<u32>> {
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
    pub(in crate::model) fn behind(&self, group: &[u32]) -> Vec<u32> {
        let sets = group.iter().flat_map(|&n| &self.0[n as usize]);
        sets.fold(Vec::new(), |all, set| union(&all, set))
    }
}

/// The union of two ascending lists.
pub(in crate::model) fn union(a: &[u32], b: &[u32]) -> Vec<u32> {
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
pub(in crate::model) fn order(nodes: &[Node]) -> Vec<u32> {
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

/// Own nodes behind a mapped node with its present parents.
#[derive(Clone, Default)]
pub(in crate::model) struct Ancestors {
    /// Each once.
    pub nodes: Vec<u32>,
    /// For each parent and each own node behind it, its first column in the operators.
    pub columns: Vec<u32>,
    /// Number of their coordinates.
    pub coordinates: usize,
}

/// The present ancestors of all mapped nodes, parents first.
#[derive(Clone, Default)]
pub(in crate::model) struct Dependencies(pub(in crate::model) Vec<Ancestors>);

impl Dependencies {
    /// The present own nodes behind a node.
    pub(in crate::model) fn behind<'a>(&'a self, nodes: &[Node], n: &'a u32) -> &'a [u32] {
        match &nodes[*n as usize].source {
            Source::Own => std::slice::from_ref(n),
            Source::Mapped(d) => &self.0[d.index].nodes,
        }
    }

    /// Finds the ancestors for the present parents.
    pub(in crate::model) fn find(&mut self, nodes: &[Node], order: &[u32], maps: &Maps) {
        let dim = |m: u32| nodes[m as usize].dim;
        for &n in order {
            let Source::Mapped(d) = &nodes[n as usize].source else {
                continue;
            };
            let mut own = std::mem::take(&mut self.0[d.index]);
            own.nodes.clear();
            own.columns.clear();
            own.coordinates = 0;
            for m in d.parents(maps) {
                // The ancestors of one parent are all different.
                let before = own.nodes.len();
                for &a in self.behind(nodes, m) {
                    let known = own.nodes[..before].iter().position(|&x| x == a);
                    if let Some(k) = known {
                        let first: usize = own.nodes[..k].iter().map(|&x| dim(x)).sum();
                        own.columns.push(first as u32);
                    } else {
                        own.columns.push(own.coordinates as u32);
                        own.nodes.push(a);
                        own.coordinates += dim(a);
                    }
                }
            }
            self.0[d.index] = own;
        }
    }
}

/// Assigns space for operators, and for all ancestors that a node may have; returns the number of
/// values of the operators.
pub(in crate::model) fn arrange(
    nodes: &mut [Node],
    order: &[u32],
    alternatives: &Alternatives,
) -> (usize, Dependencies) {
    let mut len = 0;
    let mut dependencies = Dependencies::default();
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
            (d.index, d.chained, d.local) = (dependencies.0.len(), chained, len);
            len += dim * d.direct;
            d.total = d.local;
            if chained {
                d.total = len;
                len += dim * most;
            }
        }
        dependencies.0.push(Ancestors {
            nodes: Vec::with_capacity(longest),
            columns: Vec::with_capacity(entries),
            coordinates: 0,
        });
    }
    (len, dependencies)
}
