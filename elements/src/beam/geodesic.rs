//! Geodesic interpolation: rotations relative to a node of the element.
//!
//! With E_i = R_rᵀ R_i of the nodes relative to the reference node r,
//!
//! ```text
//! z_i = R_rᵀ (x_i − x_r),   ϑ_i = log E_i,   R(ξ) = R_r exp(Σ N_i(ξ) ϑ_i)
//! ```
//!
//! The strains Γ = Rᵀx′ − X′ and K are those of the line Σ N_i z_i with the rotation vector Σ N_i
//! ϑ_i: functions of relative quantities alone, hence invariant (Crisfield & Jelenić 1999). Their
//! kernel is evaluated in (z, ϑ); this file is the map from the nodes' coordinates to these, and
//! its pull-back in closed form. With material variations δΘ = T δΨ,
//!
//! ```text
//! δz_i = R_rᵀ (δd_i − δd_r) + z_i~ δΘ_r,     δϑ_i = T⁻¹(ϑ_i) δΘ_i − T⁻ᵀ(ϑ_i) δΘ_r
//! ```

use super::element::Beam;
use super::interpolation::{Rotations, Seen};
use super::mass::MassPoint;
use super::nodal::NodalInertia;
use super::relative::{RelativeNode, RelativePose, Turn, block, turn_between};
use crate::blocks::{add_block, three};
use crate::element::{CombinedTangents, Motion, ONE_TURN};
use nalgebra::{Matrix3, Vector3, Vector6};
use pullback_manifold::domain::{CHART_EDGE, DomainError, LARGEST_ANGLE};
use pullback_manifold::quotients::TangentQuotients;
use pullback_manifold::so3;
use pullback_manifold::system::Weights;

/// The geodesic interpolation; see [`Interpolation::Geodesic`](super::Interpolation::Geodesic).
///
/// The reference node is the first of two, the middle one of three, and the second of four.
#[derive(Clone, Debug)]
pub struct Geodesic<const NN: usize> {
    /// Reference positions relative to the reference node.
    arms: [Vector3<f64>; NN],
    inertia: Option<NodalInertia<NN>>,
}

impl<const NN: usize> Geodesic<NN> {
    /// The reference node.
    const R: usize = (NN - 1) / 2;

    /// z and ϑ of node i; the two rotation vectors determine the branch of ϑ.
    fn relative(&self, x: &[f64], i: usize, R_t: &Matrix3<f64>) -> RelativePose {
        let apart = self.arms[i] + three(x, 6 * i) - three(x, 6 * Self::R);
        RelativePose {
            z: R_t * apart,
            theta: Self::turn_between(x, i),
        }
    }

    /// ϑ_i of node i.
    fn turn_between(x: &[f64], i: usize) -> Vector3<f64> {
        turn_between(&three(x, 6 * Self::R + 3), &three(x, 6 * i + 3))
    }

    /// Indices of the nodes that are not the reference.
    fn others() -> impl Iterator<Item = usize> {
        (0..NN).filter(|&i| i != Self::R)
    }

    /// x̂ at `from`, and x̂ + B (x − from) with B there.
    fn linear(&self, from: &[f64], x: &[f64]) -> [[[f64; 6]; NN]; 2] {
        let mut step = [[0.0; 6]; NN];
        for (step, (x, from)) in step.as_flattened_mut().iter_mut().zip(x.iter().zip(from)) {
            *step = x - from;
        }
        let seen = self.seen(from, step.as_flattened());
        let to = |i: usize| std::array::from_fn(|k| seen.x[i][k] + seen.v[i][k]);
        [seen.x, std::array::from_fn(to)]
    }

    /// The nodes that are not the reference, with their indices.
    fn seen_nodes(
        nodes: &[Option<RelativeNode>; NN],
    ) -> impl Iterator<Item = (usize, &RelativeNode)> {
        let nodes = nodes.iter().enumerate();
        nodes.filter_map(|(i, node)| Some((i, node.as_ref()?)))
    }

    /// Coordinates (d̂, Ψ̂) of node i.
    fn local(&self, i: usize, seen: &RelativePose) -> [f64; 6] {
        let d = seen.z - self.arms[i];
        let psi = seen.theta;
        [d.x, d.y, d.z, psi.x, psi.y, psi.z]
    }
}

impl<const NN: usize> Rotations<NN> for Geodesic<NN> {
    fn new(positions: &[Vector3<f64>; NN], masses: Option<[MassPoint<NN>; NN]>) -> Self {
        Self {
            arms: positions.map(|p| p - positions[Self::R]),
            inertia: masses.map(|m| NodalInertia::new(&m)),
        }
    }

    fn seen(&self, x: &[f64], v: &[f64]) -> Seen<NN> {
        let reference = Turn::new(three(x, 6 * Self::R + 3));
        let R_t = so3::rotation(&-reference.psi);
        let mut out = Seen {
            R: R_t.transpose(),
            x: [[0.0; 6]; NN],
            v: [[0.0; 6]; NN],
        };
        for i in Self::others() {
            let seen = self.relative(x, i, &R_t);
            out.x[i] = self.local(i, &seen);
            if !v.is_empty() {
                let turn = Turn::new(three(x, 6 * i + 3));
                let node = RelativeNode::new(turn, seen, &reference, &R_t);
                out.v[i] = node.rates(&v[6 * i..], &v[6 * Self::R..]).into();
            }
        }
        out
    }

    fn section(x: &[f64], N: &[f64; NN]) -> (Matrix3<f64>, [Matrix3<f64>; NN]) {
        let reference = Turn::new(three(x, 6 * Self::R + 3));
        let R = so3::R(&reference.psi, &reference.quotients.tangent());
        // R = R_r E(ϑ), ϑ = Σ N_i ϑ_i: δΘ = Eᵀ δΘ_r + T(ϑ) Σ N_i δϑ_i.
        let mut theta = Vector3::zeros();
        let mut Theta_psi = [Matrix3::zeros(); NN];
        for i in Self::others() {
            let own = Self::turn_between(x, i);
            theta += own * N[i];
            let T_inverse = so3::tangent_inverse(&own) * N[i];
            Theta_psi[i] = T_inverse * Turn::new(three(x, 6 * i + 3)).T;
            Theta_psi[Self::R] -= T_inverse.transpose() * reference.T;
        }
        let c = TangentQuotients::new(theta.norm_squared());
        let (E, T) = (so3::R(&theta, &c), so3::T(&theta, &c));
        let mut Theta_psi = Theta_psi.map(|Theta_psi| T * Theta_psi);
        Theta_psi[Self::R] += E.tr_mul(&reference.T);
        (R * E, Theta_psi)
    }

    fn pull_back(
        beam: &Beam<NN, Self>,
        at: &Motion<'_>,
        r: &mut [f64],
        tangents: &mut CombinedTangents<'_>,
    ) -> Result<(), DomainError> {
        let reference = Turn::new(three(at.x, 6 * Self::R + 3));
        let (rotations, viscous) = (&beam.rotations, beam.is_viscous(at));
        let (nodes, x, v) = rotations.nodes(viscous, at, &reference)?;
        let moving = if viscous { v.as_flattened() } else { &[] };
        let linear = at.previous.map(|from| rotations.linear(from, at.x));
        let there = Motion {
            t: at.t,
            inputs: at.inputs,
            x: x.as_flattened(),
            v: moving,
            a: &[],
            previous: linear.as_ref().map(|[from, _]| from.as_flattened()),
        };
        let predicted = linear.as_ref().map_or(&x, |[_, to]| to);
        let (mut force, mut f_sigma) = ([[0.0; 6]; NN], [[0.0; 6]; NN]);
        let (mut K, mut C) = ([[[[0.0; 6]; NN]; 6]; NN], [[[[0.0; 6]; NN]; 6]; NN]);
        let wanted = tangents.iter().flatten().any(|t| t.0.K != 0.0)
            || viscous && tangents.iter().flatten().any(|t| t.0.C != 0.0);
        let K_hat = K.as_flattened_mut().as_flattened_mut().as_flattened_mut();
        let C_hat = C.as_flattened_mut().as_flattened_mut().as_flattened_mut();
        let mut parts: CombinedTangents<'_> = [
            wanted.then_some((Weights::STATIC, &mut *K_hat)),
            (wanted && viscous).then_some((Weights::DAMPING, &mut *C_hat)),
            None,
        ];
        let residuals = [force.as_flattened_mut(), f_sigma.as_flattened_mut()];
        beam.strain(&there, predicted.as_flattened(), residuals, &mut parts)?;
        let others = || Self::seen_nodes(&nodes);
        for (i, node) in others() {
            let f = Vector6::from(force[i]);
            let (own, turn) = (node.B.own.tr_mul(&f), node.B.reference.tr_mul(&f));
            for k in 0..6 {
                r[6 * i + k] += own[k];
                r[6 * Self::R + k] += turn[k];
            }
        }
        if !wanted {
            return Ok(());
        }
        for (weights, out) in tangents.iter_mut().flatten() {
            let Weights { K: k, C: c, .. } = *weights;
            if k == 0.0 && (c == 0.0 || !viscous) {
                continue;
            }
            let to = (&reference, &nodes);
            Self::add_products((at, viscous), to, [K_hat, C_hat], [k, c], out);
            for (i, node) in others().filter(|_| k != 0.0) {
                let forces = [0, 3].map(|c| three(&f_sigma[i], c) * -k);
                node.add_geometric(&reference, forces, out, 6 * NN, [6 * i, 6 * Self::R]);
            }
        }
        Ok(())
    }

    fn inertia(
        &self,
        at: &Motion<'_>,
        alpha: f64,
        r: &mut [f64],
        tangents: &mut CombinedTangents<'_>,
    ) {
        if let Some(inertia) = &self.inertia {
            inertia.add(at, alpha, r, tangents);
        }
    }

    fn kinetic_energy(&self, at: &Motion<'_>) -> f64 {
        let inertia = self.inertia.as_ref();
        inertia.map_or(0.0, |inertia| inertia.kinetic_energy(at))
    }
}

/// Nodes that are not the reference, with x̂ and its rates.
type SeenNodes<const NN: usize> = ([Option<RelativeNode>; NN], [[f64; 6]; NN], [[f64; 6]; NN]);

impl<const NN: usize> Geodesic<NN> {
    /// The nodes as the reference sees them, at rest unless `viscous`.
    #[inline]
    fn nodes(
        &self,
        viscous: bool,
        at: &Motion<'_>,
        reference: &Turn,
    ) -> Result<SeenNodes<NN>, DomainError> {
        let R_t = so3::R(&reference.psi, &reference.quotients.tangent()).transpose();
        let (mut x, mut v) = ([[0.0; 6]; NN], [[0.0; 6]; NN]);
        let mut nodes: [Option<RelativeNode>; NN] = std::array::from_fn(|_| None);
        for i in Self::others() {
            let seen = self.relative(at.x, i, &R_t);
            DomainError::within(LARGEST_ANGLE - seen.theta.norm(), ONE_TURN)?;
            x[i] = self.local(i, &seen);
            let node = RelativeNode::new(Turn::new(three(at.x, 6 * i + 3)), seen, reference, &R_t);
            if viscous {
                v[i] = node.rates(&at.v[6 * i..], &at.v[6 * Self::R..]).into();
            }
            nodes[i] = Some(node);
        }
        // If both are at the edge, the relative rotation is the better message.
        for i in 0..NN {
            let psi = three(at.x, 6 * i + 3).norm();
            DomainError::within(LARGEST_ANGLE - psi, CHART_EDGE)?;
        }
        Ok((nodes, x, v))
    }

    /// Adds the factors of K and C times Bᵀ(K̂ B + Ĉ Ḃ) and Bᵀ Ĉ B.
    #[inline]
    fn add_products(
        (at, viscous): (&Motion<'_>, bool),
        (reference, nodes): (&Turn, &[Option<RelativeNode>; NN]),
        [K_hat, C_hat]: [&[f64]; 2],
        [k, c]: [f64; 2],
        out: &mut [f64],
    ) {
        let n = 6 * NN;
        let others = || Self::seen_nodes(nodes);
        for (j, right) in others() {
            let B_dot = viscous.then(|| {
                let rates = right.rates(&at.v[6 * j..], &at.v[6 * Self::R..]);
                let [own, far] = [j, Self::R].map(|k| three(at.v, 6 * k + 3));
                right.B_dot(&rates, reference, &own, &far)
            });
            for (i, left) in others() {
                // Columns K B + C Ḃ of the two nodes, with their weights.
                let mut weighted = block(K_hat, n, i, j, k);
                if viscous {
                    weighted += block(C_hat, n, i, j, c);
                }
                let mut own = weighted * right.B.own;
                let mut far = weighted * right.B.reference;
                if let Some(B_dot) = &B_dot {
                    let C = block(C_hat, n, i, j, k);
                    own += C * B_dot.own;
                    far += C * B_dot.reference;
                }
                let rows = [left.B.own.transpose(), left.B.reference.transpose()];
                for (row, B) in [i, Self::R].into_iter().zip(&rows) {
                    add_block(out, n, 6 * row, 6 * j, &(B * own));
                    add_block(out, n, 6 * row, 6 * Self::R, &(B * far));
                }
            }
        }
    }
}
