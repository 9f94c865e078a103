//! Stiffness-proportional Kelvin-Voigt damping: stresses β C (Γ̇, K̇).

use super::strain::{Gradients, Law, Strained};
use crate::element::CombinedTangents;
use nalgebra::{Matrix3, SMatrix, Vector3};
use pullback_manifold::jet::Grad;
use pullback_manifold::quotients::Quotients;
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::{self, skew};

/// Strain operator B = ∂(Γ,K)/∂(x′,Ψ′,Ψ) and its time derivative, and the law times β.
pub(super) struct Viscous {
    B: SMatrix<f64, 6, 9>,
    B_dot: SMatrix<f64, 6, 9>,
    C: SMatrix<f64, 6, 6>,
    /// (Γ̇, K̇).
    rates: SMatrix<f64, 6, 1>,
}

type Jet = Grad<Grad<f64, 1>, 3>;

impl Viscous {
    /// Adds the viscous stresses to those of `strained`.
    pub(super) fn new(
        strained: &mut Strained,
        line: &Gradients,
        rates: &Gradients,
        law: &Law,
        beta: f64,
    ) -> Self {
        let quotients = Quotients::new(line.psi.norm());
        let (R, T, g) = (strained.R, strained.T, strained.g);
        let T_dot = so3::T_dot(&rates.psi, &line.psi, &quotients);
        let Omega = T * rates.psi;
        // Rᵀ changes by −Ω~Rᵀ, g = Rᵀx′ by Γ̇.
        let Gamma_dot = R.tr_mul(&rates.x_prime) + g.cross(&Omega);
        let (C1, C1_dot) = bending(line, rates);
        let mut B = SMatrix::<f64, 6, 9>::zeros();
        let mut B_dot = B;
        let put = |B: &mut SMatrix<f64, 6, 9>, row: usize, column: usize, block: &Matrix3<f64>| {
            B.fixed_view_mut::<3, 3>(row, column).copy_from(block);
        };
        put(&mut B, 0, 0, &R.transpose());
        put(&mut B, 0, 6, &(skew(&g) * T));
        put(&mut B, 3, 3, &T);
        put(&mut B, 3, 6, &C1);
        put(&mut B_dot, 0, 0, &(skew(&Omega) * R.transpose() * -1.0));
        put(&mut B_dot, 0, 6, &(skew(&Gamma_dot) * T + skew(&g) * T_dot));
        put(&mut B_dot, 3, 3, &T_dot);
        put(&mut B_dot, 3, 6, &C1_dot);
        let K_dot = T * rates.psi_prime + C1 * rates.psi;
        let mut C = SMatrix::<f64, 6, 6>::zeros();
        C.fixed_view_mut::<3, 3>(0, 0).copy_from(&(law.GG * beta));
        C.fixed_view_mut::<3, 3>(0, 3).copy_from(&(law.GK * beta));
        C.fixed_view_mut::<3, 3>(3, 0)
            .copy_from(&(law.GK.transpose() * beta));
        C.fixed_view_mut::<3, 3>(3, 3).copy_from(&(law.KK * beta));
        let rates = SMatrix::<f64, 6, 1>::from_fn(|i, _| match i {
            0..3 => Gamma_dot[i],
            _ => K_dot[i - 3],
        });
        let stress = C * rates;
        strained.N += stress.fixed_rows::<3>(0);
        strained.M += stress.fixed_rows::<3>(3);
        Self { B, B_dot, C, rates }
    }

    /// Power lost per unit length, (Γ̇, K̇)·βC(Γ̇, K̇).
    pub(super) fn power(&self) -> f64 {
        self.rates.dot(&(self.C * self.rates))
    }

    /// Adds C = Bᵀ βC B and to K the part Bᵀ βC Ḃ; K_σ includes the viscous stresses.
    pub(super) fn add_tangents<const NN: usize>(
        &self,
        N: &[f64; NN],
        dN: &[f64; NN],
        weight: f64,
        tangents: &mut CombinedTangents<'_>,
    ) {
        let left = self.B.tr_mul(&self.C) * weight;
        for (weights, out) in tangents.iter_mut().flatten() {
            if weights.K != 0.0 || weights.C != 0.0 {
                let right = self.B * weights.C + self.B_dot * weights.K;
                spread(&(left * right), N, dN, out);
            }
        }
    }
}

/// C₁(Ψ′,Ψ) and its time derivative: K = TΨ′ differentiated with respect to Ψ and along the motion.
fn bending(line: &Gradients, rates: &Gradients) -> (Matrix3<f64>, Matrix3<f64>) {
    let moving = |x: f64, v: f64| Grad { v: x, g: [v] };
    let psi = Vector3::from_fn(|i, _| {
        let mut jet = Jet::constant(0.0);
        jet.v = moving(line.psi[i], rates.psi[i]);
        jet.g[i] = Grad::constant(1.0);
        jet
    });
    let psi_prime = Vector3::from_fn(|i, _| {
        let mut jet = Jet::constant(0.0);
        jet.v = moving(line.psi_prime[i], rates.psi_prime[i]);
        jet
    });
    let K = so3::tangent(&psi) * psi_prime;
    (
        Matrix3::from_fn(|i, j| K[i].g[j].v),
        Matrix3::from_fn(|i, j| K[i].g[j].g[0]),
    )
}

/// Adds a matrix over (x′, Ψ′, Ψ) to the nodes, with N_i and N_i′.
fn spread<const NN: usize>(D: &SMatrix<f64, 9, 9>, N: &[f64; NN], dN: &[f64; NN], out: &mut [f64]) {
    let n = 6 * NN;
    // Coordinate k of a node enters x′ or Ψ′ (row k of D), its rotation also Ψ.
    let parts = |i: usize, k: usize| [(k, dN[i]), (k + 3, if k < 3 { 0.0 } else { N[i] })];
    for j in 0..NN {
        for c in 0..6 {
            for i in 0..NN {
                for r in 0..6 {
                    let mut sum = 0.0;
                    for (row, a) in parts(i, r) {
                        for (column, b) in parts(j, c) {
                            sum += a * b * D[(row, column)];
                        }
                    }
                    out[6 * i + r + (6 * j + c) * n] += sum;
                }
            }
        }
    }
}
