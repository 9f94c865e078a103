//! Entries of a few nodes in the vectors of all nodes.

use crate::model::Span;

/// Gathers the coordinates of some nodes; returns their number.
pub(in crate::model) fn collect(of: &[u32], spans: &[Span], x: &[f64], out: &mut [f64]) -> usize {
    let mut k = 0;
    for &m in of {
        let from = &x[spans[m as usize].range()];
        copy(from, &mut out[k..k + from.len()]);
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
        add(own, mine, 1.0);
    }
}

/// Copies values, those of a frame without a call.
#[inline(always)]
pub(in crate::model) fn copy(from: &[f64], to: &mut [f64]) {
    match (
        <&[f64; 6]>::try_from(from),
        <&mut [f64; 6]>::try_from(&mut *to),
    ) {
        (Ok(from), Ok(to)) => *to = *from,
        _ => to.copy_from_slice(from),
    }
}

/// out += factor x, for a frame without a loop.
#[inline(always)]
pub(in crate::model) fn add(out: &mut [f64], x: &[f64], factor: f64) {
    if let (Ok(out), Ok(x)) = (
        <&mut [f64; 6]>::try_from(&mut *out),
        <&[f64; 6]>::try_from(x),
    ) {
        for k in 0..6 {
            out[k] += factor * x[k];
        }
        return;
    }
    for (o, x) in out.iter_mut().zip(x) {
        *o += factor * x;
    }
}
