//! Entries of a few nodes in the vectors of all nodes.

use crate::model::Span;

/// Gathers the coordinates of some nodes; returns their number.
pub(in crate::model) fn collect(of: &[u32], spans: &[Span], x: &[f64], out: &mut [f64]) -> usize {
    let mut k = 0;
    for &m in of {
        let from = &x[spans[m as usize].range()];
        let to = &mut out[k..k + from.len()];
        // Most nodes are frames: six values are copied without a call.
        match (
            <&mut [f64; 6]>::try_from(&mut *to),
            <&[f64; 6]>::try_from(from),
        ) {
            (Ok(to), Ok(from)) => *to = *from,
            _ => to.copy_from_slice(from),
        }
        k += from.len();
    }
    k
}

/// Adds the entries of some nodes to those of all: the reverse of `collect`.
pub(in crate::model) fn distribute(of: &[u32], spans: &[Span], local: &[f64], all: &mut [f64]) {
    let mut rest = local;
    for &node in of {
        let own = &mut all[spans[node as usize].range()];
        let (mine, others) = rest.split_at(own.len());
        rest = others;
        // Most nodes are frames: six sums without a loop.
        if let (Ok(own), Ok(mine)) = (
            <&mut [f64; 6]>::try_from(&mut *own),
            <&[f64; 6]>::try_from(mine),
        ) {
            for k in 0..6 {
                own[k] += mine[k];
            }
            continue;
        }
        for (a, l) in own.iter_mut().zip(mine) {
            *a += l;
        }
    }
}
