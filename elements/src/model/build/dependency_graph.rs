//! Dependencies of mapped nodes on own nodes, and the order of evaluation.

use crate::memory;
use crate::model::kinematics::mapped_node::{MappedNode, Maps};
use crate::model::{ModelError, Node, Nodes, Subject};
use std::collections::BTreeSet;

/// For every node, all sets of own nodes that it can depend on: one for each combination of
/// segments, each ascending and without repetition.
pub(in crate::model) struct Alternatives(Vec<Vec<Vec<u32>>>);

impl Alternatives {
    /// The sets of all nodes.
    ///
    /// # Errors
    /// [`ModelError::Chain`] if there is not enough memory for all dependencies.
    pub(in crate::model) fn new(nodes: &Nodes) -> Result<Self, ModelError> {
        let own = |(n, node): (usize, &Node)| match node.is_own() {
            true => vec![vec![n as u32]],
            false => Vec::new(),
        };
        let mut all = Self(nodes.iter().enumerate().map(own).collect());
        let mut coordinates = 0.0;
        for (n, _, d) in nodes.mapped() {
            let mut sets: Vec<Vec<u32>> = d.segments.iter().flat_map(|s| all.of(s)).collect();
            sets.sort_unstable();
            sets.dedup();
            let behind = sets.iter().flatten().map(|&m| nodes[m as usize].dim);
            coordinates += behind.sum::<usize>() as f64;
            memory::followed(coordinates).map_err(|[needs, free]| ModelError::Chain {
                node: Subject::node(nodes, n),
                needs,
                free,
            })?;
            all.0[n as usize] = sets;
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
}

/// The union of two ascending lists.
fn union(a: &[u32], b: &[u32]) -> Vec<u32> {
    let mut out = [a, b].concat();
    // Stable: two ascending runs are merged in linear time.
    out.sort();
    out.dedup();
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
            let node = &nodes[n as usize];
            if !node.is_own() {
                waiting.push((n, true));
                waiting.extend(node.all_parents().rev().map(|m| (m, false)));
            }
        }
    }
    out
}

/// The nodes of a group and all those that they depend on by some of their sets of parents, ascending; `end` and
/// what only it depends on are left out.
pub(in crate::model) fn ancestors<'a>(
    nodes: &'a [Node],
    group: &[u32],
    end: Option<u32>,
    parents: impl Fn(&'a MappedNode) -> &'a [Vec<u32>],
) -> Vec<u32> {
    let (mut waiting, mut met) = (group.to_vec(), BTreeSet::new());
    while let Some(n) = waiting.pop() {
        if end != Some(n)
            && met.insert(n)
            && let Some(d) = nodes[n as usize].mapped()
        {
            waiting.extend(parents(d).iter().flatten());
        }
    }
    met.into_iter().collect()
}

/// The nodes of a group and all those that they depend on with their present parents, ascending.
pub(in crate::model) fn behind(nodes: &[Node], maps: &Maps, group: &[u32]) -> Vec<u32> {
    ancestors(nodes, group, None, |d| {
        std::slice::from_ref(&d.segments[maps[d.index].segment()])
    })
}

/// Numbers the mapped nodes, and arranges their operators; returns the number of values of these.
pub(in crate::model) fn arrange(nodes: &mut Nodes) -> usize {
    let mut end = 0;
    for (index, &n) in nodes.mapped.iter().enumerate() {
        let node = &mut nodes.all[n as usize];
        if let Some(d) = &mut node.map {
            (d.index, d.operators) = (index, end..end + node.dim * d.direct);
            end = d.operators.end;
        }
    }
    end
}
