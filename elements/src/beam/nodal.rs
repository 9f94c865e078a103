//! Inertia of a beam by the angular velocities of its nodes.
//!
//! Velocities of the axis are interpolated by the shape functions, like positions; so are the
//! material angular velocities Ω_i = T(Ψ_i) Ψ̇_i and the velocities R_i (Ω_i × c) that they give to
//! a mass centre at c. The kinetic energy is then
//!
//! ```text
//! T = Σ_ij ½ m_ij ḋ_i·ḋ_j + ḋ_i·R_j (Ω_j × S_ij) + ½ Ω_i·J_ij Ω_j,   (m, S, J)_ij = ∫ N_i N_j (m, S, J)
//! ```
//!
//! a function of the nodes' rotations and angular velocities that is independent of rigid rotations
//! and charts, exact if the element moves as a rigid straight body, and accurate to the
//! interpolation error otherwise. Its Lagrange equations conserve momenta and energy:
//!
//! ```text
//! f_acc,i = Σ_j m_ij d̈_j + R_j (A_j × S_ij + Ω_j × (Ω_j × S_ij)),
//! T_iᵀ h_i,  h_i = Σ_j J_ij A_j + Ω_i × J_ij Ω_j + S_ij × R_iᵀ d̈_j
//! ```
//!
//! which is (119) of \[M04\] if all nodes have the same motion.

#![allow(non_snake_case)]

use super::mass::MassPoint;
use crate::blocks::{add_block, three};
use crate::element::{CombinedTangents, Motion};
use crate::inertia::{Inertia, centrifugal};
use nalgebra::{Matrix3, Vector3};
use pullback_manifold::quotients::Quotients;
use pullback_manifold::so3::{self, skew};
use pullback_manifold::system::Weights;

/// The integrals (m, S, J)_ij of an element, components in the global frame of the reference
/// configuration.
#[derive(Clone, Debug)]
pub(super) struct NodalInertia<const NN: usize> {
    pairs: [[Inertia; NN]; NN],
    /// Whether any S is not zero.
    eccentric: bool,
}

/// Motion of a node.
struct Spin {
    psi: Vector3<f64>,
    psi_dot: Vector3<f64>,
    psi_ddot: Vector3<f64>,
    x_ddot: Vector3<f64>,
    quotients: Quotients,
    R: Matrix3<f64>,
    T: Matrix3<f64>,
    Omega: Vector3<f64>,
    A: Vector3<f64>,
}

/// Variation of Ω and A of a node with (Ψ, Ψ̇, Ψ̈), with the weights of a tangent: δΩ = C₁ δΨ + T δΨ̇,
/// δA = (C₅ + C₁(Ψ̈)) δΨ + C₄ δΨ̇ + T δΨ̈.
struct Variation {
    Omega: Matrix3<f64>,
    A: Matrix3<f64>,
}

impl Spin {
    /// The motion of a node with accelerations increased by α times the velocities: inertia is
    /// linear in accelerations, so this adds the drag α M ẋ.
    fn new(at: &Motion<'_>, node: usize, alpha: f64) -> Self {
        let first = 6 * node + 3;
        let (psi, psi_dot) = (three(at.x, first), three(at.v, first));
        let psi_ddot = three(at.a, first) + psi_dot * alpha;
        let quotients = Quotients::new(psi.norm());
        let c = quotients.tangent();
        let T = so3::T(&psi, &c);
        Self {
            R: so3::R(&psi, &c),
            Omega: T * psi_dot,
            A: T * psi_ddot + so3::T_dot_psi_dot(&psi_dot, &psi, &quotients),
            x_ddot: three(at.a, 6 * node) + three(at.v, 6 * node) * alpha,
            psi,
            psi_dot,
            psi_ddot,
            quotients,
            T,
        }
    }

    fn variation(&self, w: &Weights) -> Variation {
        let (psi, psi_dot, c) = (&self.psi, &self.psi_dot, &self.quotients);
        let mut by = Variation {
            Omega: Matrix3::zeros(),
            A: self.T * w.M,
        };
        if w.K != 0.0 || w.C != 0.0 {
            by.Omega = so3::C1(psi_dot, psi, c) * w.K + self.T * w.C;
            by.A = so3::A_varied([w.K, w.C, w.M], psi_dot, &self.psi_ddot, psi, c);
        }
        by
    }

    /// A×S + Ω×(Ω×S), mass times the acceleration of the mass centre relative to the node.
    fn l(&self, S: &Vector3<f64>) -> Vector3<f64> {
        self.A.cross(S) + self.Omega.cross(&self.Omega.cross(S))
    }
}

impl<const NN: usize> NodalInertia<NN> {
    pub(super) fn new(points: &[MassPoint<NN>; NN]) -> Self {
        let mut pairs = [[Inertia::default(); NN]; NN];
        for p in points {
            for (i, row) in pairs.iter_mut().enumerate() {
                for (j, pair) in row.iter_mut().enumerate() {
                    let weight = p.weight * p.N[i] * p.N[j];
                    pair.mass += weight * p.inertia.mass;
                    pair.S += p.inertia.S * weight;
                    pair.J += p.inertia.J * weight;
                }
            }
        }
        Self {
            pairs,
            eccentric: points.iter().any(|p| p.inertia.S != Vector3::zeros()),
        }
    }

    /// Adds −f_acc, the drag α p, and their tangents.
    pub(super) fn add(
        &self,
        at: &Motion<'_>,
        alpha: f64,
        r: &mut [f64],
        tangents: &mut CombinedTangents<'_>,
    ) {
        let spins: [Spin; NN] = std::array::from_fn(|i| Spin::new(at, i, alpha));
        let moments = self.forces(&spins, r);
        for (weights, out) in tangents.iter_mut().flatten() {
            // Accelerations contain α times the velocities.
            let w = Weights {
                M: weights.M + alpha * weights.C,
                ..*weights
            };
            let by: [Variation; NN] = std::array::from_fn(|j| spins[j].variation(&w));
            for (i, [h, momentum]) in moments.iter().enumerate() {
                self.tangent(i, &spins, &by, &w, out);
                // The terms of the node's own rotation and angular velocity.
                let Spin {
                    psi,
                    quotients,
                    R,
                    T,
                    ..
                } = &spins[i];
                let mut own = skew(momentum) * by[i].Omega * -1.0;
                if self.eccentric {
                    for (pair, spin) in self.pairs[i].iter().zip(&spins) {
                        own += skew(&pair.S) * skew(&R.tr_mul(&spin.x_ddot)) * T * w.K;
                    }
                }
                let own = so3::C2(h, psi, quotients) * w.K + T.tr_mul(&own);
                add_block(out, 6 * NN, 6 * i + 3, 6 * i + 3, &own);
            }
        }
    }

    /// Adds −f_acc. Returns h_i and Σ_j J_ij Ω_j of each node.
    fn forces(&self, spins: &[Spin; NN], r: &mut [f64]) -> [[Vector3<f64>; 2]; NN] {
        std::array::from_fn(|i| {
            let own = &spins[i];
            let (mut f, mut h, mut momentum) =
                (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
            for (Inertia { mass, S, J }, spin) in self.pairs[i].iter().zip(spins) {
                f += spin.x_ddot * *mass;
                h += J * spin.A;
                momentum += J * spin.Omega;
                if self.eccentric {
                    f += spin.R * spin.l(S);
                    h += S.cross(&own.R.tr_mul(&spin.x_ddot));
                }
            }
            h += own.Omega.cross(&momentum);
            let covector = own.T.tr_mul(&h);
            for k in 0..3 {
                r[6 * i + k] -= f[k];
                r[6 * i + 3 + k] -= covector[k];
            }
            [h, momentum]
        })
    }

    /// Adds the tangents of node i with respect to the velocities and accelerations of all nodes.
    fn tangent(
        &self,
        i: usize,
        spins: &[Spin; NN],
        by: &[Variation; NN],
        w: &Weights,
        out: &mut [f64],
    ) {
        let (n, own) = (6 * NN, &spins[i]);
        for (j, (Inertia { mass, S, J }, by)) in self.pairs[i].iter().zip(by).enumerate() {
            for k in 0..3 {
                out[6 * i + k + (6 * j + k) * n] += mass * w.M;
            }
            let h_q = J * by.A + skew(&own.Omega) * (J * by.Omega);
            add_block(out, n, 6 * i + 3, 6 * j + 3, &own.T.tr_mul(&h_q));
            if self.eccentric {
                let Spin { R, T, Omega, .. } = &spins[j];
                let S_skew = skew(S);
                let lever = own.T.tr_mul(&S_skew) * own.R.transpose() * w.M;
                add_block(out, n, 6 * i + 3, 6 * j, &lever);
                let l = skew(&spins[j].l(S)) * T * w.K;
                let l_q = centrifugal(Omega, S) * by.Omega - S_skew * by.A - l;
                add_block(out, n, 6 * i, 6 * j + 3, &(R * l_q));
            }
        }
    }
}
