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

use super::mass::MassPoint;
use crate::blocks::{add_block, three};
use crate::element::{CombinedTangents, Motion};
use crate::inertia::{FrameMotion, Inertia, centrifugal};
use nalgebra::{Matrix3, Vector3};
use pullback_manifold::quotients::TangentQuotients;
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
            eccentric: points.iter().any(|p| p.inertia.is_eccentric()),
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
        let spins: [FrameMotion; NN] = std::array::from_fn(|i| {
            let [v, a] = [at.v, at.a].map(|x| [three(x, 6 * i), three(x, 6 * i + 3)]);
            FrameMotion::new(three(at.x, 6 * i + 3), v, a, alpha, self.eccentric)
        });
        let moments = self.forces(&spins, r);
        for (weights, out) in tangents.iter_mut().flatten() {
            // Accelerations contain α times the velocities.
            let w = Weights {
                M: weights.M + alpha * weights.C,
                ..*weights
            };
            let by = spins.each_ref().map(|spin| spin.varied(&w));
            for (i, [h, momentum]) in moments.iter().enumerate() {
                self.tangent(i, &spins, &by, &w, out);
                // The terms of the node's own rotation and angular velocity.
                let FrameMotion {
                    psi,
                    quotients,
                    R,
                    T,
                    ..
                } = &spins[i];
                let mut own = skew(momentum) * by[i][0] * -1.0;
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

    /// T, see above.
    pub(super) fn kinetic_energy(&self, at: &Motion<'_>) -> f64 {
        let moving = |i: usize| {
            let (psi, psi_dot) = (three(at.x, 6 * i + 3), three(at.v, 6 * i + 3));
            let c = TangentQuotients::new(psi.norm_squared());
            (three(at.v, 6 * i), psi, so3::spun(&psi, &psi_dot, &c), c)
        };
        let nodes: [_; NN] = std::array::from_fn(moving);
        let mut energy = 0.0;
        for ((d_dot, _, Omega, _), row) in nodes.iter().zip(&self.pairs) {
            for ((d_dot_j, psi, Omega_j, c), Inertia { mass, S, J }) in nodes.iter().zip(row) {
                energy += 0.5 * (mass * d_dot.dot(d_dot_j) + Omega.dot(&(J * Omega_j)));
                if self.eccentric {
                    energy += d_dot.dot(&so3::turned(psi, &Omega_j.cross(S), c));
                }
            }
        }
        energy
    }

    /// Adds −f_acc. Returns h_i and Σ_j J_ij Ω_j of each node.
    fn forces(&self, spins: &[FrameMotion; NN], r: &mut [f64]) -> [[Vector3<f64>; 2]; NN] {
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
        spins: &[FrameMotion; NN],
        by: &[[Matrix3<f64>; 2]; NN],
        w: &Weights,
        out: &mut [f64],
    ) {
        let (n, own) = (6 * NN, &spins[i]);
        for (j, (Inertia { mass, S, J }, [Omega_q, A_q])) in
            self.pairs[i].iter().zip(by).enumerate()
        {
            for k in 0..3 {
                out[6 * i + k + (6 * j + k) * n] += mass * w.M;
            }
            let h_q = J * A_q + skew(&own.Omega) * (J * Omega_q);
            add_block(out, n, 6 * i + 3, 6 * j + 3, &own.T.tr_mul(&h_q));
            if self.eccentric {
                let FrameMotion { R, T, Omega, .. } = &spins[j];
                let S_skew = skew(S);
                let lever = own.T.tr_mul(&S_skew) * own.R.transpose() * w.M;
                add_block(out, n, 6 * i + 3, 6 * j, &lever);
                let l = skew(&spins[j].l(S)) * T * w.K;
                let l_q = centrifugal(Omega, S) * Omega_q - S_skew * A_q - l;
                add_block(out, n, 6 * i, 6 * j + 3, &(R * l_q));
            }
        }
    }
}
