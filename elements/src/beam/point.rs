//! One integration point of the internal force.

use super::strain::{ConjugateForces, Law, SectionStiffness};
use nalgebra::{Matrix3, Vector3};

/// One integration point: shape functions, reference shape, section law.
#[derive(Clone, Debug)]
pub(super) struct GaussPoint<const NN: usize> {
    /// Shape functions N_i and their derivatives with respect to the arc length.
    pub N: [f64; NN],
    pub dN: [f64; NN],
    /// Weight times length per unit of ξ.
    pub weight: f64,
    /// Reference position, tangent of unit length, section axes.
    pub X: Vector3<f64>,
    pub X_prime: Vector3<f64>,
    pub R0: Matrix3<f64>,
    pub law: Law,
}

impl<const NN: usize> GaussPoint<NN> {
    /// Subtracts the forces over (x′, Ψ′, Ψ) from those of the nodes.
    #[inline]
    pub(super) fn subtract(&self, f: &ConjugateForces, r: &mut [f64]) {
        for (i, r) in r.chunks_exact_mut(6).enumerate() {
            let (a, b) = (self.weight * self.dN[i], self.weight * self.N[i]);
            for k in 0..3 {
                r[k] -= a * f.x_prime[k];
                r[3 + k] -= a * f.psi_prime[k] + b * f.psi[k];
            }
        }
    }

    /// Adds the stiffness over (x′, Ψ′, Ψ) to the nodes: upper blocks only, the lower ones are
    /// mirrored.
    #[inline]
    pub(super) fn spread(&self, D: &SectionStiffness, weight: f64, K: &mut [f64]) {
        let n = 6 * NN;
        for j in 0..NN {
            for i in 0..=j {
                let dd = weight * self.dN[i] * self.dN[j];
                let dn = weight * self.dN[i] * self.N[j];
                let nd = weight * self.N[i] * self.dN[j];
                let nn = weight * self.N[i] * self.N[j];
                let xx = D.xx * dd;
                let xr = D.xp * dd + D.xq * dn;
                let rx = (D.xp * dd + D.xq * nd).transpose();
                let rr = D.pp * dd + D.pq * dn + (D.pq * nd).transpose() + D.qq * nn;
                for c in 0..3 {
                    let start = 6 * i + (6 * j + c) * n;
                    for (top, bottom, start) in [(&xx, &rx, start), (&xr, &rr, start + 3 * n)] {
                        let K = &mut K[start..start + 6];
                        for r in 0..3 {
                            K[r] += top[(r, c)];
                            K[3 + r] += bottom[(r, c)];
                        }
                    }
                }
            }
        }
    }
}

/// Copies the blocks above the diagonal below it.
#[inline]
pub(super) fn mirror<const NN: usize>(K: &mut [f64]) {
    let n = 6 * NN;
    for j in 1..NN {
        for i in 0..j {
            for c in 0..6 {
                for r in 0..6 {
                    K[6 * j + c + (6 * i + r) * n] = K[6 * i + r + (6 * j + c) * n];
                }
            }
        }
    }
}
