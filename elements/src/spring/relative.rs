//! The relative displacement and rotation of two frames, with their derivatives.

#![allow(non_snake_case)]

use nalgebra::{Matrix3, SMatrix, SVector, Vector3, Vector6};
use pullback_manifold::quotients::{InverseQuotients, Quotients};
use pullback_manifold::so3::{self, skew};

type Vector12 = SVector<f64, 12>;

/// The map (x₁, x₂) → y = (u, θ), u = R₁ᵀ(x₂ − x₁) − u₀, θ = log(R₁ᵀR₂).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Relative {
    /// R₁ᵀ(x₂ − x₁) in the reference configuration.
    pub u0: Vector3<f64>,
}

/// One configuration of the two frames.
pub(super) struct Relation {
    /// (u, θ).
    pub y: Vector6<f64>,
    psi: [Vector3<f64>; 2],
    theta: Vector3<f64>,
    /// Rᵢ, for the first frame only.
    R: Matrix3<f64>,
    T: [Matrix3<f64>; 2],
    /// T⁻¹(θ).
    T_inverse: Matrix3<f64>,
    /// R₁ᵀ(x₂ − x₁).
    g: Vector3<f64>,
    quotients: [Quotients; 2],
}

impl Relative {
    /// At the coordinates of both frames (12).
    pub(super) fn at(&self, x: &[f64]) -> Relation {
        let triple = |i: usize| Vector3::new(x[i], x[i + 1], x[i + 2]);
        let psi = [triple(3), triple(9)];
        let quotients = psi.map(|psi| Quotients::new(psi.norm()));
        let [c1, c2] = [quotients[0].tangent(), quotients[1].tangent()];
        let R = so3::R(&psi[0], &c1);
        let g = R.tr_mul(&(triple(6) - triple(0) + self.u0));
        let [first, second] = psi.map(|psi| so3::quaternion(&psi));
        let theta = so3::log_quaternion(&first.conjugate().product(&second));
        let u = g - self.u0;
        Relation {
            y: Vector6::new(u.x, u.y, u.z, theta.x, theta.y, theta.z),
            psi,
            theta,
            R,
            T: [so3::T(&psi[0], &c1), so3::T(&psi[1], &c2)],
            T_inverse: so3::tangent_inverse(&theta),
            g,
            quotients,
        }
    }
}

impl Relation {
    /// ∂θ/∂Ψ₁ = −T⁻ᵀ T₁ and ∂θ/∂Ψ₂ = T⁻¹ T₂, from Θ-variations δΘ₂ − R₁₂ᵀ δΘ₁ with T⁻¹R₁₂ᵀ = T⁻ᵀ.
    fn theta_psi(&self) -> [Matrix3<f64>; 2] {
        [
            -(self.T_inverse.tr_mul(&self.T[0])),
            self.T_inverse * self.T[1],
        ]
    }

    /// B = ∂y/∂x, 6×12.
    pub(super) fn B(&self) -> SMatrix<f64, 6, 12> {
        let R = self.R.transpose();
        let mut B = SMatrix::<f64, 6, 12>::zeros();
        let mut put = |i, j, block: &Matrix3<f64>| {
            B.fixed_view_mut::<3, 3>(i, j).copy_from(block);
        };
        put(0, 0, &-R);
        put(0, 3, &(skew(&self.g) * self.T[0]));
        put(0, 6, &R);
        let [first, second] = self.theta_psi();
        put(3, 3, &first);
        put(3, 9, &second);
        B
    }

    /// Ḃ along the velocities v, 6×12; `y_dot` = B v.
    pub(super) fn B_dot(&self, v: &Vector12, y_dot: &Vector6<f64>) -> SMatrix<f64, 6, 12> {
        let triple = |i: usize| Vector3::new(v[i], v[i + 1], v[i + 2]);
        let psi_dot = [triple(3), triple(9)];
        let T_dot: [Matrix3<f64>; 2] =
            std::array::from_fn(|i| so3::T_dot(&psi_dot[i], &self.psi[i], &self.quotients[i]));
        let Omega = self.T[0] * psi_dot[0];
        let g_dot = Vector3::new(y_dot[0], y_dot[1], y_dot[2]);
        let theta_dot = Vector3::new(y_dot[3], y_dot[4], y_dot[5]);
        // d/dt Rᵀ = −Ω~Rᵀ and d/dt T⁻¹ = −T⁻¹ Ṫ T⁻¹.
        let R_dot = -(skew(&Omega) * self.R.transpose());
        let turning = so3::T_dot(&theta_dot, &self.theta, &Quotients::new(self.theta.norm()));
        let T_inverse_dot = -(self.T_inverse * turning * self.T_inverse);
        let mut B = SMatrix::<f64, 6, 12>::zeros();
        let mut put = |i, j, block: &Matrix3<f64>| {
            B.fixed_view_mut::<3, 3>(i, j).copy_from(block);
        };
        put(0, 0, &-R_dot);
        let arm = skew(&g_dot) * self.T[0] + skew(&self.g) * T_dot[0];
        put(0, 3, &arm);
        put(0, 6, &R_dot);
        let first = T_inverse_dot.tr_mul(&self.T[0]) + self.T_inverse.tr_mul(&T_dot[0]);
        put(3, 3, &-first);
        let second = T_inverse_dot * self.T[1] + self.T_inverse * T_dot[1];
        put(3, 9, &second);
        B
    }

    /// K_σ(f) = D_x(Bᵀf) for fixed f = (n, m), symmetric 12×12.
    pub(super) fn K_sigma(&self, f: &Vector6<f64>) -> SMatrix<f64, 12, 12> {
        let (n, m) = (
            Vector3::new(f[0], f[1], f[2]),
            Vector3::new(f[3], f[4], f[5]),
        );
        let [T1, T2] = &self.T;
        // The covectors are R₁n for x₂ and −x₁, T₁ᵀ(n × g − T⁻¹m) for Ψ₁ and T₂ᵀT⁻ᵀm for Ψ₂.
        let moment = n.cross(&self.g) - self.T_inverse * m;
        let second = self.T_inverse.tr_mul(&m);
        let force = -(self.R * (skew(&n) * T1));
        let inverse = InverseQuotients::new(self.theta.norm());
        // D_θ(T⁻ᵀm), and D_θ(T⁻¹m) = −C₆(m, −θ) because T⁻¹(θ) = T⁻ᵀ(−θ).
        let C6 = so3::C6(&m, &self.theta, &inverse);
        let C6_opposite = -so3::C6(&m, &-self.theta, &inverse);
        let [theta_1, theta_2] = self.theta_psi();
        let first_first = so3::C2(&moment, &self.psi[0], &self.quotients[0])
            + T1.tr_mul(&(skew(&n) * (skew(&self.g) * T1) - C6_opposite * theta_1));
        let second_first = T2.tr_mul(&(C6 * theta_1));
        let second_second =
            so3::C2(&second, &self.psi[1], &self.quotients[1]) + T2.tr_mul(&(C6 * theta_2));
        let mut K = SMatrix::<f64, 12, 12>::zeros();
        let mut put = |i, j, block: &Matrix3<f64>| {
            K.fixed_view_mut::<3, 3>(i, j).copy_from(block);
            K.fixed_view_mut::<3, 3>(j, i).copy_from(&block.transpose());
        };
        put(0, 3, &-force);
        put(6, 3, &force);
        put(9, 3, &second_first);
        // On the diagonal round-off alone is not symmetric.
        put(3, 3, &((first_first + first_first.transpose()) * 0.5));
        put(9, 9, &((second_second + second_second.transpose()) * 0.5));
        K
    }
}
