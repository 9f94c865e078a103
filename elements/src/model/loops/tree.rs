//! The equations of closed loops: compositions of the maps along their chains.

#![allow(non_snake_case)]
#![allow(
    clippy::needless_range_loop,
    reason = "orders of derivatives and matrices in slices are read by their indices"
)]

use super::link::{Link, Read, add_product};
use crate::joint::Pose;
use nalgebra::{SVector, Vector3};
use pullback_manifold::map::{KinematicsMut, Map, Parametrization};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::system::ChartChanges;

/// Two coinciding frames: the gap to frame a in the axes of frame b, and twice the vector part of
/// the quaternion with a positive scalar part that rotates b to a; independent of the branches of
/// the rotation vectors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::model) struct Coincide {
    /// From b to a in the reference configuration.
    pub apart: Vector3<f64>,
}

impl Map<12, 6> for Coincide {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 12>) -> SVector<S, 6> {
        let (a, b) = (Pose::of(q, 0), Pose::of(q, 6));
        let back = b.rotation.conjugate();
        let gap = back.rotate(&(a.d - b.d + self.apart.map(S::constant)));
        let turn = back.product(&a.rotation);
        let turn = turn.v * S::constant(2.0_f64.copysign(turn.w.re()));
        SVector::<S, 6>::new(gap.x, gap.y, gap.z, turn.x, turn.y, turn.z)
    }
}

/// A tree of maps from common inputs; its values are those of its last links, the closures.
#[derive(Default)]
pub(super) struct Tree {
    inputs: usize,
    closures: usize,
    links: Vec<Link>,
    K: Vec<f64>,
    stack: Vec<f64>,
    product: Vec<f64>,
}

impl Tree {
    /// A tree without links.
    pub(super) fn new(inputs: usize) -> Self {
        Self {
            inputs,
            ..Self::default()
        }
    }

    /// Adds a link; returns its index.
    pub(super) fn link(
        &mut self,
        map: Box<dyn Parametrization>,
        reads: Vec<(Read, usize)>,
    ) -> usize {
        let (d, n) = map.dims();
        let sources: Vec<Vec<usize>> = (reads.iter())
            .map(|&(read, len)| match read {
                Read::Input(first) => (first..first + len).collect(),
                Read::Nothing => Vec::new(),
                Read::Link(j) => self.links[j].columns.clone(),
            })
            .collect();
        let mut columns = sources.concat();
        columns.sort_unstable();
        columns.dedup();
        let position = |input: &usize| columns.partition_point(|c| c < input);
        let positions = sources.iter().map(|s| s.iter().map(position).collect());
        let positions = positions.collect();
        let N = columns.len();
        let z = |len: usize| [vec![0.0; len], vec![0.0; len], vec![0.0; len]];
        self.K.resize(self.K.len().max(d * d), 0.0);
        self.stack.resize(self.stack.len().max(d * N), 0.0);
        self.product.resize(self.product.len().max(d * N), 0.0);
        self.links.push(Link {
            map,
            reads,
            columns,
            positions,
            n,
            d,
            q: z(d),
            x: z(n),
            own: z(n * d),
            all: z(n * N),
            r: vec![0.0; n],
        });
        self.links.len() - 1
    }

    /// Adds the equations that two frames coincide.
    pub(super) fn close(&mut self, between: Coincide, frames: [Read; 2]) {
        self.link(between.boxed(), frames.map(|r| (r, 6)).to_vec());
        self.closures += 1;
    }

    /// Evaluates all links at y: tangents without `rates`, kinematics with them.
    fn evaluate(&mut self, t: f64, y: &[f64], rates: Option<[&[f64]; 2]>) {
        let orders = if rates.is_some() { 3 } else { 1 };
        let [v, a] = rates.unwrap_or([&[], &[]]);
        for k in 0..self.links.len() {
            let (before, rest) = self.links.split_at_mut(k);
            let link = &mut rest[0];
            link.gather(before, [y, v, a], orders);
            if orders == 1 {
                link.map
                    .tangent(t, &link.q[0], &mut link.x[0], &mut link.own[0]);
            } else {
                let [x, x_dot, x_ddot] = &mut link.x;
                let [B, B_dot, B_ddot] = &mut link.own;
                let out = KinematicsMut {
                    x,
                    x_dot,
                    x_ddot,
                    B,
                    B_dot,
                    B_ddot,
                };
                let [q, v, a] = &link.q;
                link.map.kinematics(t, q, v, a, out);
            }
            link.chain(before, orders);
        }
    }

    /// Copies values of the closures, one under the other.
    fn collect(&self, order: usize, out: &mut [f64]) {
        let first = self.links.len() - self.closures;
        for (out, link) in out.chunks_exact_mut(6).zip(&self.links[first..]) {
            out.copy_from_slice(&link.x[order]);
        }
    }

    /// Copies operators of the closures, one under the other.
    fn collect_operators(&self, order: usize, out: &mut [f64]) {
        let M = 6 * self.closures;
        out.fill(0.0);
        let first = self.links.len() - self.closures;
        for (c, link) in self.links[first..].iter().enumerate() {
            for (&j, B) in link.columns.iter().zip(link.all[order].chunks_exact(6)) {
                out[j * M + 6 * c..j * M + 6 * (c + 1)].copy_from_slice(B);
            }
        }
    }
}

impl Parametrization for Tree {
    fn kind(&self) -> &'static str {
        "closed loop"
    }

    fn dims(&self) -> (usize, usize) {
        (self.inputs, 6 * self.closures)
    }

    fn duplicate(&self) -> Box<dyn Parametrization> {
        let mut copy = Self::new(self.inputs);
        for link in &self.links {
            copy.link(link.map.clone(), link.reads.clone());
        }
        copy.closures = self.closures;
        Box::new(copy)
    }

    /// Chooses the branch of the rotation vector of each link, from the root outwards.
    fn change_charts(&mut self, t: f64, y: &[f64]) -> ChartChanges {
        let mut all = ChartChanges::default();
        for k in 0..self.links.len() {
            let (before, rest) = self.links.split_at_mut(k);
            let link = &mut rest[0];
            link.gather(before, [y, &[], &[]], 1);
            all.charts += link.map.change_charts(t, &link.q[0]).charts;
            link.map
                .tangent(t, &link.q[0], &mut link.x[0], &mut link.own[0]);
        }
        all
    }

    fn freeze_piece(&mut self, at: Option<(f64, &[f64])>) {
        if let Some((t, y)) = at {
            self.evaluate(t, y, None);
        }
        for link in &mut self.links {
            link.map.freeze_piece(at.map(|(t, _)| (t, &link.q[0][..])));
        }
    }

    fn tangent(&mut self, t: f64, y: &[f64], h: &mut [f64], J: &mut [f64]) {
        self.evaluate(t, y, None);
        self.collect(0, h);
        self.collect_operators(0, J);
    }

    fn kinematics(&mut self, t: f64, y: &[f64], v: &[f64], a: &[f64], out: KinematicsMut<'_>) {
        self.evaluate(t, y, Some([v, a]));
        for (k, x) in [out.x, out.x_dot, out.x_ddot].into_iter().enumerate() {
            self.collect(k, x);
        }
        for (k, B) in [out.B, out.B_dot, out.B_ddot].into_iter().enumerate() {
            self.collect_operators(k, B);
        }
    }

    fn geometric_stiffness(&mut self, t: f64, y: &[f64], f: &[f64], K: &mut [f64]) {
        let N = self.inputs;
        self.evaluate(t, y, None);
        K.fill(0.0);
        self.links.iter_mut().for_each(|l| l.r.fill(0.0));
        let first = self.links.len() - self.closures;
        for (link, f) in self.links[first..].iter_mut().zip(f.chunks_exact(6)) {
            link.r.copy_from_slice(f);
        }
        for k in (0..self.links.len()).rev() {
            let (before, rest) = self.links.split_at_mut(k);
            let link = &mut rest[0];
            if link.r.iter().all(|r| *r == 0.0) {
                continue;
            }
            let (d, columns) = (link.d, &link.columns);
            let own = &mut self.K[..d * d];
            link.map.geometric_stiffness(t, &link.q[0], &link.r, own);
            // Operators of the coordinates with respect to the inputs, and Bᵀ r for their sources.
            let stack = &mut self.stack[..d * columns.len()];
            stack.fill(0.0);
            let mut column = 0;
            for (&(read, len), positions) in link.reads.iter().zip(&link.positions) {
                match read {
                    Read::Nothing => {}
                    Read::Input(_) => {
                        for (i, &position) in positions.iter().enumerate() {
                            stack[column + i + position * d] += 1.0;
                        }
                    }
                    Read::Link(j) => {
                        let from = before[j].all[0].chunks_exact(len);
                        for (&position, from) in positions.iter().zip(from) {
                            let at = position * d + column;
                            stack[at..at + len].copy_from_slice(from);
                        }
                        let B = &link.own[0][column * link.n..];
                        for (r, B) in before[j].r.iter_mut().zip(B.chunks_exact(link.n)) {
                            *r += B.iter().zip(&link.r).map(|(b, r)| b * r).sum::<f64>();
                        }
                    }
                }
                column += len;
            }
            let product = &mut self.product[..d * columns.len()];
            product.fill(0.0);
            add_product([d, d], 1.0, own, stack, product);
            for (&j, p) in columns.iter().zip(product.chunks_exact(d)) {
                for (&i, s) in columns.iter().zip(stack.chunks_exact(d)) {
                    K[i + j * N] += s.iter().zip(p).map(|(s, p)| s * p).sum::<f64>();
                }
            }
        }
    }
}

/// Some consecutive unknowns of a loop, as the coordinates of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Part {
    /// Number of all unknowns, index of the first one, and their number.
    pub of: usize,
    pub first: usize,
    pub len: usize,
}

impl Parametrization for Part {
    fn kind(&self) -> &'static str {
        "in a loop"
    }

    fn dims(&self) -> (usize, usize) {
        (self.of, self.len)
    }

    fn duplicate(&self) -> Box<dyn Parametrization> {
        Box::new(*self)
    }

    fn is_linear(&self) -> bool {
        true
    }

    fn tangent(&mut self, _t: f64, q: &[f64], x: &mut [f64], B: &mut [f64]) {
        x.copy_from_slice(&q[self.first..self.first + self.len]);
        B.fill(0.0);
        for i in 0..self.len {
            B[i + (self.first + i) * self.len] = 1.0;
        }
    }

    fn kinematics(&mut self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: KinematicsMut<'_>) {
        self.tangent(t, q, out.x, out.B);
        out.x_dot
            .copy_from_slice(&v[self.first..self.first + self.len]);
        out.x_ddot
            .copy_from_slice(&a[self.first..self.first + self.len]);
        out.B_dot.fill(0.0);
        out.B_ddot.fill(0.0);
    }

    fn geometric_stiffness(&mut self, _t: f64, _q: &[f64], _f: &[f64], K: &mut [f64]) {
        K.fill(0.0);
    }
}
