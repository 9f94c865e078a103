//! Elimination order of the block graph: exact minimum degree.
//!
//! The elimination graph is kept explicitly: eliminating a node joins its neighbours into a
//! clique. That costs as many operations as the block factorisation has block updates, so it is
//! cheap exactly where the block factorisation is, and a bound on the updates ends both early.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use pullback_manifold::sparse::BlockPattern;

use super::LinearError;

/// An elimination order with the structure of the factors that it makes.
pub(super) struct Elimination {
    /// Node eliminated k-th.
    pub order: Vec<u32>,
    /// For each elimination step the neighbours still alive, in no particular order.
    pub later: Vec<Vec<u32>>,
}

/// Minimum degree order, degree counted in unknowns.
///
/// Ties go to the node with the *highest* number. Bodies are numbered from the base outward in
/// nearly every model, so chains and trees are eliminated from their tips towards the base, as the
/// recursive algorithms of multibody dynamics do: the Schur complement of a part that is attached to one
/// node without other support vanishes, and the pivot of that node is the stiffness of its next
/// element, undamaged by cancellation. In the opposite direction the pivots are the stiffness of
/// the supported part at its end, which falls with the cube of its length and holds fewer and
/// fewer digits. It also walks through memory in one direction.
///
/// A node is eliminated after those of lower [`ranks`] that it is coupled to.
pub(super) fn minimum_degree(
    pattern: &BlockPattern,
    max_updates: usize,
) -> Result<Elimination, LinearError> {
    let n = pattern.blocks();
    let size = |i: u32| pattern.size(i as usize);
    // Sorted lists that may still hold eliminated nodes; empty blocks take no part.
    let mut neighbours: Vec<Vec<u32>> = (0..n)
        .map(|j| {
            pattern
                .column(j)
                .map(|(i, _)| i as u32)
                .filter(|&i| i as usize != j && size(i) > 0 && pattern.size(j) > 0)
                .collect()
        })
        .collect();
    let mut degree: Vec<usize> = neighbours
        .iter()
        .map(|list| list.iter().map(|&i| size(i)).sum())
        .collect();
    let mut alive = vec![true; n];
    let rank = ranks(pattern, &neighbours);
    let waits_for = |i: usize, j: u32| rank[j as usize] < rank[i];
    let mut waiting: Vec<usize> = (neighbours.iter().enumerate())
        .map(|(i, list)| list.iter().filter(|&&j| waits_for(i, j)).count())
        .collect();
    let mut heap: BinaryHeap<(Reverse<usize>, u32)> =
        (0..n).map(|i| (Reverse(degree[i]), i as u32)).collect();
    let mut remaining = n;
    let mut weight = pattern.dim();
    let mut updates = 0;
    let mut order = Vec::with_capacity(n);
    let mut later = Vec::with_capacity(n);
    while let Some((Reverse(d), k)) = heap.pop() {
        // The heap holds outdated degrees of nodes whose degree has changed since.
        if !alive[k as usize] || d != degree[k as usize] || waiting[k as usize] > 0 {
            continue;
        }
        if d > 0 && d + size(k) == weight {
            break; // even the least connected node is coupled to all others: one clique is left
        }
        alive[k as usize] = false;
        for (i, _) in pattern.column(k as usize) {
            if waits_for(i, k) && size(k) > 0 && pattern.size(i) > 0 {
                waiting[i] -= 1;
            }
        }
        remaining -= 1;
        weight -= size(k);
        let mut clique = std::mem::take(&mut neighbours[k as usize]);
        clique.retain(|&i| alive[i as usize]);
        updates += clique.len() * clique.len();
        if updates > max_updates {
            return Err(LinearError::Fill { limit: max_updates });
        }
        for &i in &clique {
            let list = &mut neighbours[i as usize];
            let degree = &mut degree[i as usize];
            if clique.len() <= SHORT {
                *degree -= size(k);
                for &w in clique.iter().filter(|&&w| w != i) {
                    if let Err(position) = list.binary_search(&w) {
                        list.insert(position, w);
                        *degree += size(w);
                    }
                }
            } else {
                // Two sorted runs, which the sort merges.
                list.extend(&clique);
                list.sort();
                list.dedup();
                list.retain(|&w| w != i && alive[w as usize]);
                *degree = list.iter().map(|&w| size(w)).sum();
            }
            heap.push((Reverse(*degree), i));
        }
        order.push(k);
        later.push(clique);
    }
    if updates + remaining * remaining * remaining / 3 > max_updates {
        return Err(LinearError::Fill { limit: max_updates });
    }
    let mut rest: Vec<u32> = (0..n as u32).filter(|&i| alive[i as usize]).collect();
    rest.sort_by_key(|&i| Reverse(rank[i as usize]));
    while let Some(k) = rest.pop() {
        order.push(k);
        later.push(rest.clone());
    }
    Ok(Elimination { order, later })
}

/// In a saddle point matrix [A Gᵀ; G 0] a multiplier has a pivot, −G A⁻¹ Gᵀ, once the nodes in its
/// equations are eliminated: its rank is one. Nodes that are coupled to nothing else (the angle of
/// a joint that closes a loop) often have neither mass nor stiffness, and get their pivot from the
/// multiplier: their rank is two. If a multiplier has no pivot left, a solver with row interchanges
/// is used.
fn ranks(pattern: &BlockPattern, neighbours: &[Vec<u32>]) -> Vec<u8> {
    let of = |i: u32| &pattern.coordinates()[pattern.unknowns(i as usize)];
    let multiplies = |i: u32| of(i).iter().all(|c| c.is_multiplier);
    let within = |list: &[u32], m: u32| {
        let known = &neighbours[m as usize];
        multiplies(m) && (list.iter()).all(|i| *i == m || known.binary_search(i).is_ok())
    };
    let rank = |(i, list): (usize, &Vec<u32>)| match multiplies(i as u32) {
        true => 1,
        false if list.iter().any(|&m| within(list, m)) => 2,
        false => 0,
    };
    neighbours.iter().enumerate().map(rank).collect()
}

/// Cliques up to this size are inserted one by one, so that a hub of many short spokes is not
/// merged anew (all its length) with every spoke.
const SHORT: usize = 8;
