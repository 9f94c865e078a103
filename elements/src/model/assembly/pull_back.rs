//! The pull-back of tangents from a mapped node to its parents.
//!
//! A mapped node n with the operator B to its parents p is coupled with nodes j and with itself. Their
//! tangents pass to the parents, the last link of a chain first (\[M04\] (180), (183), for a tree the
//! composite-rigid-body algorithm of Featherstone 2008):
//!
//! ```text
//! K_pj += Bᵀ K_nj                                        likewise C, M
//! K_jp += K_jn B + C_jn Ḃ + M_jn B̈     C_jp += C_jn B + 2 M_jn Ḃ     M_jp += M_jn B
//! K_pp += Bᵀ (K_nn B + C_nn Ḃ + M_nn B̈) − K_σ            likewise C, M
//! ```
//!
//! The weighted sum cK K + cC C + cM M is added to the pattern, for own nodes. As the columns of a mapped
//! node are stored transposed ([`Coupled`](crate::model::assembly::couplings::Coupled)), nearly all are
//! products Bᵀ f of vectors.

use crate::model::NONE;
use crate::model::assembly::couplings::CoupledBlock;
use crate::model::assembly::scatter::ScatterTarget;
use crate::model::assembly::scatter_map::ScatterMap;
use crate::model::kinematics::node_entries::add;
use std::ops::Range;

/// Number of coordinates of a pose.
const POSE: usize = 6;

/// Binomial coefficients: factors of B, Ḃ and B̈ in the products of each order.
const FACTORS: [[f64; 3]; 3] = [[1.0, 1.0, 1.0], [1.0, 2.0, 0.0], [1.0, 0.0, 0.0]];

/// The operators B, Ḃ and B̈ (n×d, by columns) of a mapped node.
///
/// That of a joint between poses has the columns A of the parent's pose before those of the joint's own
/// coordinates, A = \[1 −ρ~; 0 1\]: a link costs little more than the transport of a rigid body.
#[derive(Clone, Copy)]
pub(in crate::model) struct Operator<'a> {
    n: usize,
    d: usize,
    B: [&'a [f64]; 3],
    /// Whether Ḃ or B̈ is not zero.
    moves: bool,
    /// The lever ρ of a joint between poses, with its rates.
    lever: Option<[[f64; 3]; 3]>,
}

impl<'a> Operator<'a> {
    /// The operators of a node with n coordinates; of a joint from pose to pose, if `links_poses`.
    pub(in crate::model) fn new(n: usize, B: [&'a [f64]; 3], links_poses: bool) -> Self {
        let lever = |B: &[f64]| [B[5 * POSE + 1], B[3 * POSE + 2], B[4 * POSE]];
        Self {
            n,
            d: B[0].len() / n,
            B,
            moves: B[1..].iter().any(|B| B.iter().any(|b| *b != 0.0)),
            lever: links_poses.then(|| B.map(lever)),
        }
    }

    /// Bᵀ f of vectors of these orders (K, C, M), which are `stride` apart; with `rates`, the
    /// products with Ḃ and B̈ that the transposed columns need. The results are d apart.
    #[inline(always)]
    fn transposed(
        &self,
        needed: &Range<usize>,
        rates: bool,
        f: &[f64],
        stride: usize,
        out: &mut [f64],
    ) {
        let (orders, factors) = (needed.len(), &FACTORS[needed.start..]);
        match (&self.lever, orders) {
            (Some(lever), 1) => self.transposed_link::<1>(lever, factors, rates, f, stride, out),
            (Some(lever), 2) => self.transposed_link::<2>(lever, factors, rates, f, stride, out),
            (Some(lever), _) => self.transposed_link::<3>(lever, factors, rates, f, stride, out),
            (None, _) => {
                for (order, out) in out.chunks_exact_mut(self.d).enumerate().take(orders) {
                    let last = if rates && self.moves {
                        orders - order
                    } else {
                        1
                    };
                    for (k, B) in self.B[..last].iter().enumerate() {
                        let f = &f[(order + k) * stride..][..self.n];
                        for (out, B) in out.iter_mut().zip(B.chunks_exact(self.n)) {
                            let product = factors[order][k] * dot(B, f);
                            *out = if k == 0 { product } else { *out + product };
                        }
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn transposed_link<const ORDERS: usize>(
        &self,
        lever: &[[f64; 3]; 3],
        factors: &[[f64; 3]],
        rates: bool,
        f: &[f64],
        stride: usize,
        out: &mut [f64],
    ) {
        let f: [[f64; POSE]; ORDERS] = std::array::from_fn(|order| pose(&f[order * stride..]));
        for (order, out) in out.chunks_exact_mut(self.d).enumerate().take(ORDERS) {
            let (to, own) = out.split_at_mut(POSE);
            let mut at_parent = f[order];
            let last = if rates { ORDERS - order } else { 1 };
            for k in 0..last {
                let [x, y, z] = lever[k].map(|rho| factors[order][k] * rho);
                let f = &f[order + k];
                at_parent[3] += y * f[2] - z * f[1];
                at_parent[4] += z * f[0] - x * f[2];
                at_parent[5] += x * f[1] - y * f[0];
            }
            to.copy_from_slice(&at_parent);
            for (j, own) in own.iter_mut().enumerate() {
                *own = 0.0;
                for k in 0..last {
                    let S = pose(&self.B[k][(POSE + j) * POSE..]);
                    *own += factors[order][k] * dot(&S, &f[order + k]);
                }
            }
        }
    }

    /// out = Σ factors_k T_k B_k of matrices n×n, by columns.
    fn products(&self, factors: &[f64], T: &[f64], out: &mut [f64]) {
        match self.n {
            6 => self.products_of(6, factors, T, out),
            _ => self.products_of(self.n, factors, T, out),
        }
    }

    #[inline(always)]
    fn products_of(&self, n: usize, factors: &[f64], T: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        let factors = if self.moves { factors } else { &factors[..1] };
        for (k, (&factor, T)) in factors.iter().zip(T.chunks_exact(n * n)).enumerate() {
            let (mut columns, mut out) = (self.B[k], &mut *out);
            if let Some(lever) = &self.lever {
                let (pose, own) = out.split_at_mut(POSE * POSE);
                if k == 0 {
                    add(pose, T, factor);
                }
                let [x, y, z] = lever[k].map(|rho| factor * rho);
                if [x, y, z] != [0.0; 3] {
                    // −T ρ~, the columns of the rotation.
                    let [a, b, c] = [0, 1, 2].map(|i| &T[i * POSE..][..POSE]);
                    let turned = pose.as_chunks_mut::<POSE>().0;
                    for i in 0..POSE {
                        turned[3][i] += y * c[i] - z * b[i];
                        turned[4][i] += z * a[i] - x * c[i];
                        turned[5][i] += x * b[i] - y * a[i];
                    }
                }
                (columns, out) = (&columns[POSE * POSE..], own);
            }
            for (out, B) in out.chunks_exact_mut(n).zip(columns.chunks_exact(n)) {
                for (T, b) in T.chunks_exact(n).zip(B) {
                    if *b != 0.0 {
                        add(out, T, factor * b);
                    }
                }
            }
        }
    }
}

/// The first six values.
#[inline(always)]
fn pose(x: &[f64]) -> [f64; POSE] {
    x.first_chunk().copied().unwrap_or_default()
}

#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    if let (Ok(a), Ok(b)) = (<&[f64; 6]>::try_from(a), <&[f64; 6]>::try_from(b)) {
        let half = |k: usize| a[k] * b[k] + a[k + 1] * b[k + 1] + a[k + 2] * b[k + 2];
        return half(0) + half(3);
    }
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The block of a node and another one in the tangent of an element or, with the rows of a parent, in a pulled-back
/// matrix.
#[derive(Clone, Copy)]
pub(super) struct Piece {
    /// First coordinate of the node among those of the element or of all parents, and their number.
    pub first: u32,
    pub len: u32,
    pub block: Option<CoupledBlock>,
    /// First coordinates of both nodes, if they are own nodes: the block is one of the pattern.
    pub own: Option<[u32; 2]>,
}

impl Piece {
    /// Adds the node's part of vectors of all orders (K, C, M) at coordinate c of the other node.
    #[inline(always)]
    pub(super) fn add<'a>(
        &self,
        of_orders: impl Iterator<Item = &'a [f64]>,
        c: usize,
        free: &[u32],
        into: &mut ScatterTarget<'_>,
    ) {
        let Some(block) = self.block else {
            return;
        };
        let of_orders = of_orders.map(|f| &f[self.first as usize..]);
        let len = self.len as usize;
        let CoupledBlock {
            start, row, column, ..
        } = block;
        if let Some([node, other]) = self.own {
            let c = free[other as usize + c];
            if c == NONE {
                return;
            }
            let to = &mut into.values[start + c as usize * column..];
            for (f, weight) in of_orders.zip(into.weights) {
                for (f, r) in f[..len].iter().zip(&free[node as usize..]) {
                    if *r != NONE {
                        to[*r as usize * row] += weight * f;
                    }
                }
            }
            return;
        }
        let to = &mut into.coupled[start + c * column..];
        for (order, f) in of_orders.enumerate() {
            let to = &mut to[order * block.order..];
            if row == 1 {
                add(&mut to[..len], &f[..len], 1.0);
                continue;
            }
            for (r, f) in f[..len].iter().enumerate() {
                to[r * row] += f;
            }
        }
    }
}

impl ScatterMap {
    /// Pulls the needed tangents at the mapped node of this index back to its parents. `work` is scratch.
    pub(in crate::model) fn pull_back(
        &self,
        index: usize,
        operator: Operator<'_>,
        K_sigma: &[f64],
        into: &mut ScatterTarget<'_>,
        work: &mut [f64],
    ) {
        let Operator { n, d, .. } = operator;
        let coupled = &self.couplings.0[index];
        // The tangents of parents come before those of the nodes mapped from them.
        let (above, own) = into.coupled.split_at_mut(coupled.own);
        let needed = into.needed.clone();
        let orders = needed.len();
        let into = &mut ScatterTarget {
            values: into.values,
            coupled: above,
            needed: needed.clone(),
            ..*into
        };
        let (f, product) = work.split_at_mut(orders * d);
        let mut pieces = self.pieces[coupled.first_piece..].chunks_exact(coupled.parents.len());
        let mut put = |pieces: &[Piece], f: &[f64], c: usize| {
            for piece in pieces {
                piece.add(f.chunks_exact(d), c, &self.rows, into);
            }
        };
        let size = n * coupled.width;
        let (square, rest) = own.split_at(3 * n * n);
        let (mut rows, mut columns) = rest.split_at(3 * size);
        for partner in &coupled.partners {
            let [of_rows, of_columns] =
                [pieces.next(), pieces.next()].map(Option::unwrap_or_default);
            for c in 0..partner.dim {
                operator.transposed(&needed, false, rows, size, f);
                put(of_rows, f, c);
                operator.transposed(&needed, true, columns, size, f);
                put(of_columns, f, c);
                (rows, columns) = (&rows[n..], &columns[n..]);
            }
        }
        let size = n * d;
        for (order, product) in product.chunks_exact_mut(size).enumerate().take(orders) {
            let square = &square[order * n * n..orders * n * n];
            let factors = &FACTORS[needed.start + order][..orders - order];
            operator.products(factors, square, product);
        }
        let mut product = &*product;
        let mut K_sigma = K_sigma.chunks_exact(d);
        for (pieces, dim) in pieces.zip(&coupled.parents) {
            for (c, K_sigma) in K_sigma.by_ref().take(*dim).enumerate() {
                operator.transposed(&needed, false, product, size, f);
                add(&mut f[..d], K_sigma, -1.0);
                put(pieces, f, c);
                product = &product[n..];
            }
        }
    }
}
