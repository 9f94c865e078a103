//! The pull-back of a residual and its tangents by a map, for any element and any map (\[M04\]
//! (180), (183)).
//!
//! ```text
//! r_mr = Bᵀ r
//! M_mr = Bᵀ M B
//! C_mr = Bᵀ (C B + 2 M Ḃ)
//! K_mr = Bᵀ (K B + C Ḃ + M B̈) − K_σ(r)
//! ```
//!
//! An element's coordinates x come in slots (its nodes), each with a map of its own, so B is
//! block-diagonal; a slot without a map is the identity. With the integrator's weights the
//! three tangents combine to
//!
//! ```text
//! S_ij = B_iᵀ (W_ij B_j + Y_ij Ḃ_j + Z_ij B̈_j) − cK δ_ij K_σ,i(r_i)
//! W = cK K + cC C + cM M,   Y = cK C + 2 cC M,   Z = cK M
//! ```

#![allow(non_snake_case)]

use crate::system::Weights;

/// Kinematic operators of one slot; matrices column by column.
#[derive(Clone, Copy, Debug, Default)]
pub struct Slot<'a> {
    /// Rows n: embedding coordinates of the slot.
    pub n: usize,
    /// Columns d: coordinates after the pull-back; equal to n for the identity.
    pub d: usize,
    /// B (n×d), or `None` for the identity (then the others are not read).
    pub B: Option<&'a [f64]>,
    /// Ḃ (n×d), empty where C and M are absent.
    pub B_dot: &'a [f64],
    /// B̈ (n×d), empty where M is absent.
    pub B_ddot: &'a [f64],
    /// K_σ(r) of the slot's own residual (d×d); empty without a tangent, or if it is added elsewhere.
    pub K_sigma: &'a [f64],
}

/// Tangents of an element in its own coordinates, n×n column by column; absent ones are zero.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tangents<'a> {
    /// K = −∂r/∂x.
    pub K: Option<&'a [f64]>,
    /// C = −∂r/∂ẋ.
    pub C: Option<&'a [f64]>,
    /// M = −∂r/∂ẍ.
    pub M: Option<&'a [f64]>,
}

/// r_mr = Bᵀ r, slot by slot.
pub fn residual(slots: &[Slot<'_>], r: &[f64], r_mr: &mut [f64]) {
    let (mut row, mut column) = (0, 0);
    for slot in slots {
        let r = &r[row..row + slot.n];
        let out = &mut r_mr[column..column + slot.d];
        match slot.B {
            None => out.copy_from_slice(r),
            Some(B) => out
                .iter_mut()
                .zip(transposed(B, r))
                .for_each(|(o, f)| *o = f),
        }
        row += slot.n;
        column += slot.d;
    }
}

/// The combined tangent S_mr (d×d, column by column, overwritten) of all slots.
///
/// `work` needs room for n values, n the number of embedding coordinates.
pub fn tangent(
    slots: &[Slot<'_>],
    tangents: Tangents<'_>,
    weights: Weights,
    S_mr: &mut [f64],
    work: &mut [f64],
) {
    let n: usize = slots.iter().map(|s| s.n).sum();
    let d: usize = slots.iter().map(|s| s.d).sum();
    let work = &mut work[..n];
    let (mut x_j, mut q_j) = (0, 0);
    for sj in slots {
        for column in 0..sj.d {
            pulled_column(work, tangents, weights, x_j, sj, column);
            let out = &mut S_mr[(q_j + column) * d..(q_j + column + 1) * d];
            residual(slots, work, out);
            if let (Some(_), Some(K_sigma)) = (sj.B, sj.K_sigma.get(column * sj.d..)) {
                let own = &mut out[q_j..q_j + sj.d];
                for (s, k) in own.iter_mut().zip(K_sigma) {
                    *s -= weights.K * k;
                }
            }
        }
        x_j += sj.n;
        q_j += sj.d;
    }
}

/// The entries of Bᵀ f, one after the other; B (n×d) column by column, f with n entries.
pub fn transposed(B: &[f64], f: &[f64]) -> impl Iterator<Item = f64> {
    let columns = B.chunks_exact(f.len().max(1));
    // Most nodes are frames: a sum without a loop.
    let frame = <&[f64; 6]>::try_from(f).ok();
    columns.map(move |B| match (frame, <&[f64; 6]>::try_from(B)) {
        (Some(f), Ok(B)) => B.iter().zip(f).map(|(b, f)| b * f).sum(),
        _ => B.iter().zip(f).map(|(b, f)| b * f).sum(),
    })
}

/// out = (W B + Y Ḃ + Z B̈) e_column: one column of S_mr, of a slot whose coordinates start at the
/// element's `first`, before its rows are pulled back. `out` has the element's n rows.
fn pulled_column(
    out: &mut [f64],
    tangents: Tangents<'_>,
    weights: Weights,
    first: usize,
    slot: &Slot<'_>,
    column: usize,
) {
    out.fill(0.0);
    let Some(B) = slot.B else {
        add_column(out, tangents, weights, first + column, [1.0, 0.0, 0.0]);
        return;
    };
    for k in 0..slot.n {
        let at = column * slot.n + k;
        let factors = [
            B[at],
            slot.B_dot.get(at).copied().unwrap_or(0.0),
            slot.B_ddot.get(at).copied().unwrap_or(0.0),
        ];
        add_column(out, tangents, weights, first + k, factors);
    }
}

/// out += (b W + ḃ Y + b̈ Z) e_k, with `factors` b, ḃ, b̈.
fn add_column(
    out: &mut [f64],
    tangents: Tangents<'_>,
    weights: Weights,
    k: usize,
    factors: [f64; 3],
) {
    let n = out.len();
    let [b, b_dot, b_ddot] = factors;
    let mut add = |matrix: Option<&[f64]>, factor: f64| {
        if let Some(matrix) = matrix
            && factor != 0.0
        {
            for (o, m) in out.iter_mut().zip(&matrix[k * n..(k + 1) * n]) {
                *o += factor * m;
            }
        }
    };
    add(tangents.K, weights.K * b);
    add(tangents.C, weights.C * b + weights.K * b_dot);
    add(
        tangents.M,
        weights.M * b + 2.0 * weights.C * b_dot + weights.K * b_ddot,
    );
}
