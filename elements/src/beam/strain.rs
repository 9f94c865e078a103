//! Strains, internal forces and tangent at one point of the axis.

use nalgebra::{Matrix3, Matrix6, Vector3};
use pullback_manifold::quotients::{Quotients, TangentQuotients};
use pullback_manifold::so3::{self, skew};

/// Section law with components in the global frame of the reference configuration: rotated once by
/// R₀, which the kernel below does not need.
#[derive(Clone, Copy, Debug)]
pub(super) struct Law {
    pub GG: Matrix3<f64>,
    pub GK: Matrix3<f64>,
    pub KK: Matrix3<f64>,
}

impl Law {
    pub(super) fn rotated(C: &Matrix6<f64>, R0: &Matrix3<f64>) -> Self {
        let block = |i: usize, j: usize| {
            R0 * C.fixed_view::<3, 3>(3 * i, 3 * j).into_owned() * R0.transpose()
        };
        Self {
            GG: block(0, 0),
            GK: block(0, 1),
            KK: block(1, 1),
        }
    }

    /// The stress resultants N and M of strains Γ and K.
    #[inline]
    fn resultants(&self, Gamma: &Vector3<f64>, K: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        (
            self.GG * Gamma + self.GK * K,
            self.GK.tr_mul(Gamma) + self.KK * K,
        )
    }
}

/// Position derivative x′, rotation vector Ψ and its derivative Ψ′ at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gradients {
    pub x_prime: Vector3<f64>,
    pub psi: Vector3<f64>,
    pub psi_prime: Vector3<f64>,
}

/// Strains at a point and derived quantities: components in the global frame of the reference
/// configuration ("material" components before R₀ᵀ).
pub(super) struct Strained {
    pub R: Matrix3<f64>,
    pub T: Matrix3<f64>,
    C1: Matrix3<f64>,
    quotients: Quotients,
    /// Rᵀ x′.
    pub g: Vector3<f64>,
    pub Gamma: Vector3<f64>,
    pub K: Vector3<f64>,
    pub N: Vector3<f64>,
    pub M: Vector3<f64>,
}

/// Forces conjugate to x′, Ψ′ and Ψ: the rows of Bᵀ(N, M), \[M04\] (162).
pub(super) struct ConjugateForces {
    pub x_prime: Vector3<f64>,
    pub psi_prime: Vector3<f64>,
    pub psi: Vector3<f64>,
}

/// Blocks of BᵀCB + K_σ over (x′, Ψ′, Ψ) = (x, p, q); the rest is symmetric.
pub(super) struct SectionStiffness {
    pub xx: Matrix3<f64>,
    pub xp: Matrix3<f64>,
    pub xq: Matrix3<f64>,
    pub pp: Matrix3<f64>,
    pub pq: Matrix3<f64>,
    pub qq: Matrix3<f64>,
}

impl Strained {
    /// Strains Γ = Rᵀx′ − X′ and K = TΨ′ (\[M04\] (118)) and their resultants; X′ is the reference
    /// x′ of unit length, tangent to the reference line.
    #[inline]
    pub(super) fn new(line: &Gradients, X_prime: &Vector3<f64>, law: &Law) -> Self {
        let quotients = Quotients::new(line.psi.norm());
        let c = quotients.tangent();
        let R = so3::R(&line.psi, &c);
        let T = so3::T(&line.psi, &c);
        let g = R.tr_mul(&line.x_prime);
        let Gamma = g - X_prime;
        let K = T * line.psi_prime;
        let (N, M) = law.resultants(&Gamma, &K);
        Self {
            N,
            M,
            C1: so3::C1(&line.psi_prime, &line.psi, &quotients),
            R,
            T,
            quotients,
            g,
            Gamma,
            K,
        }
    }

    /// Bᵀ(N, M) with B = [Rᵀ 0 (Rᵀx′)~T; 0 T C₁(Ψ′,Ψ)], \[M04\] (162).
    #[inline]
    pub(super) fn forces(&self) -> ConjugateForces {
        ConjugateForces {
            x_prime: self.R * self.N,
            psi_prime: self.T.tr_mul(&self.M),
            psi: self.T.tr_mul(&self.N.cross(&self.g)) + self.C1.tr_mul(&self.M),
        }
    }

    /// BᵀCB + K_σ, \[M04\] (167).
    #[inline]
    pub(super) fn stiffness(&self, line: &Gradients, law: &Law) -> SectionStiffness {
        let Self {
            R,
            T,
            C1,
            quotients,
            g,
            N,
            M,
            ..
        } = self;
        // Columns of C B for Ψ: A = (Rᵀx′)~ T, and C₁.
        let A = skew(g) * T;
        let NT = skew(N) * T;
        let stress_q = law.GG * A + law.GK * C1;
        let moment_q = law.GK.tr_mul(&A) + law.KK * C1;
        let Nxg = N.cross(g);
        SectionStiffness {
            xx: R * law.GG * R.transpose(),
            xp: R * law.GK * T,
            xq: R * (stress_q - NT),
            pp: T.tr_mul(&(law.KK * T)),
            pq: T.tr_mul(&moment_q) + so3::C2(M, &line.psi, quotients),
            // Tᵀ N~ g~ T = −(N~T)ᵀ g~ T: with A this saves two products.
            qq: A.tr_mul(&stress_q) + C1.tr_mul(&moment_q) - NT.tr_mul(&A)
                + so3::C3(M, &line.psi_prime, &line.psi, quotients)
                + so3::C2(&Nxg, &line.psi, quotients),
        }
    }
}

/// Strain energy per unit length.
pub(super) fn strain_energy(line: &Gradients, X_prime: &Vector3<f64>, law: &Law) -> f64 {
    let c = TangentQuotients::new(line.psi.norm_squared());
    let Gamma = so3::turned(&-line.psi, &line.x_prime, &c) - X_prime;
    let K = so3::spun(&line.psi, &line.psi_prime, &c);
    let (N, M) = law.resultants(&Gamma, &K);
    0.5 * (N.dot(&Gamma) + K.dot(&M))
}

/// Stress resultants at the line `to`, extrapolated linearly from the line `from`.
///
/// Γ = Rᵀx′ − X′ is linear in x′ and K = TΨ′ in Ψ′, so that with δ = `to` − `from` and R, T at `from`
/// Γ + DΓ·δ = Rᵀx′ − X′ + g×TδΨ and K + DK·δ = TΨ′ + C₁δΨ, where x′ and Ψ′ are those of `to`.
#[inline]
pub(super) fn extrapolated(
    from: &Gradients,
    to: &Gradients,
    X_prime: &Vector3<f64>,
    law: &Law,
) -> (Vector3<f64>, Vector3<f64>) {
    let quotients = Quotients::new(from.psi.norm());
    let c = quotients.tangent();
    let d_psi = to.psi - from.psi;
    let back = -from.psi;
    let g = so3::turned(&back, &from.x_prime, &c);
    let Gamma =
        so3::turned(&back, &to.x_prime, &c) - X_prime + g.cross(&so3::spun(&from.psi, &d_psi, &c));
    let K = so3::spun(&from.psi, &to.psi_prime, &c)
        + so3::T_varied(&from.psi_prime, &d_psi, &from.psi, &quotients);
    law.resultants(&Gamma, &K)
}
