//! Inertia of matter carried by a frame: a rigid body, or a beam's cross-section per unit length.
//!
//! Mass m, first moment S and inertia J about the frame's point, material components (those of the
//! reference configuration). With the material angular velocity Ω = TΨ̇ and acceleration
//! A = TΨ̈ + ṪΨ̇ (\[M04\] (118)) the kinetic energy is
//!
//! ```text
//! ½ m ẋ·ẋ + ẋ·R(Ω~S) + ½ Ω·JΩ
//! ```
//!
//! and f_acc = d/dt ∂T/∂q̇ − ∂T/∂q, \[M04\] (119) with the terms of S,
//!
//! ```text
//! f_x = m ẍ + R g,     g = A~S + Ω~Ω~S
//! f_Ψ = Tᵀ h,          h = JA + Ω~JΩ + S~Rᵀẍ
//! ```
//!
//! [`Inertia::evaluate`] gives it with its three exact tangents, \[M04\] (147), (152) and their
//! coupling terms; fixed sizes, no heap.

#![allow(non_snake_case)]

use crate::element::{EDGE, ElementError};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use pullback_manifold::quotients::Quotients;
use pullback_manifold::so3::{self, skew};

/// Mass m, first moment S and inertia J about a frame's point; those of a body, or per unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    /// Mass m (M; M/L per unit length).
    pub m: f64,
    /// First moment S = m c, c the centre of mass seen from the point; material components (M L; M).
    pub S: Vector3<f64>,
    /// Inertia J about the point, symmetric 3×3; material components (M L²; M L).
    pub J: Matrix3<f64>,
}

/// What inertia needs of the motion of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMotion {
    /// Acceleration ẍ of the point, global components.
    pub x_ddot: Vector3<f64>,
    /// Rotation vector Ψ.
    pub psi: Vector3<f64>,
    /// Its velocity Ψ̇.
    pub psi_dot: Vector3<f64>,
    /// Its acceleration Ψ̈.
    pub psi_ddot: Vector3<f64>,
}

/// Inertia force and tangents over (x, Ψ), 6 and 6×6.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointInertia {
    /// f_acc, a covector.
    pub f: Vector6<f64>,
    /// M = ∂f_acc/∂(ẍ, Ψ̈), symmetric.
    pub M: Matrix6<f64>,
    /// C = ∂f_acc/∂(ẋ, Ψ̇).
    pub C: Matrix6<f64>,
    /// K = ∂f_acc/∂(x, Ψ).
    pub K: Matrix6<f64>,
}

/// What the force and its tangents share. R, a and g are read only where S ≠ 0.
struct Moving {
    quotients: Quotients,
    T: Matrix3<f64>,
    R: Matrix3<f64>,
    /// Material angular velocity Ω.
    Omega: Vector3<f64>,
    /// JΩ.
    L: Vector3<f64>,
    /// Rᵀẍ.
    a: Vector3<f64>,
    /// Material force and moment g, h of the module's front page.
    g: Vector3<f64>,
    h: Vector3<f64>,
    f: Vector6<f64>,
}

impl Inertia {
    /// Inertia about the point from that about the centre of mass, J_c, and the offset c of the
    /// centre of mass from the point; material components. By the parallel-axis theorem
    /// J = J_c + m (c·c I − c⊗c).
    #[must_use]
    pub fn about_point(m: f64, J_c: &Matrix3<f64>, c: &Vector3<f64>) -> Self {
        let shift = Matrix3::from_diagonal_element(c.dot(c)) - c * c.transpose();
        Self {
            m,
            S: c * m,
            J: J_c + shift * m,
        }
    }

    /// The same matter with the components of another frame, whose axes are the columns of `R0`.
    #[must_use]
    pub fn rotated(&self, R0: &Matrix3<f64>) -> Self {
        Self {
            m: self.m,
            S: R0 * self.S,
            J: R0 * self.J * R0.transpose(),
        }
    }

    /// f_acc alone; the same numbers as those of [`Inertia::evaluate`].
    ///
    /// # Errors
    /// [`ElementError::OutsideChart`] for ψ at 2π.
    #[inline]
    pub fn force(&self, at: &PointMotion) -> Result<Vector6<f64>, ElementError> {
        Ok(self.moving(at)?.f)
    }

    /// Kinetic energy ½ m ẋ·ẋ + ẋ·R(Ω~S) + ½ Ω·JΩ at velocities ẋ (global) and Ψ̇.
    #[must_use]
    pub fn kinetic_energy(
        &self,
        x_dot: &Vector3<f64>,
        psi: &Vector3<f64>,
        psi_dot: &Vector3<f64>,
    ) -> f64 {
        let Omega = so3::tangent(psi) * psi_dot;
        let coupling = (so3::rotation(psi) * Omega.cross(&self.S)).dot(x_dot);
        0.5 * self.m * x_dot.norm_squared() + coupling + 0.5 * Omega.dot(&(self.J * Omega))
    }

    /// Whether the centre of mass is away from the point.
    #[inline]
    fn is_eccentric(&self) -> bool {
        self.S != Vector3::zeros()
    }

    #[inline(always)]
    fn moving(&self, at: &PointMotion) -> Result<Moving, ElementError> {
        let psi = at.psi.norm();
        if psi > EDGE {
            return Err(ElementError::OutsideChart { psi });
        }
        let quotients = Quotients::new(psi);
        let c = quotients.tangent();
        let T = so3::T(&at.psi, &c);
        let Omega = T * at.psi_dot;
        // [M04] (118)
        let A = T * at.psi_ddot + so3::T_dot_psi_dot(&at.psi_dot, &at.psi, &quotients);
        let L = self.J * Omega;
        let mut h = self.J * A + Omega.cross(&L);
        let mut f_x = at.x_ddot * self.m;
        let (mut R, mut a, mut g) = (Matrix3::zeros(), Vector3::zeros(), Vector3::zeros());
        if self.is_eccentric() {
            R = so3::R(&at.psi, &c);
            a = R.tr_mul(&at.x_ddot);
            g = A.cross(&self.S) + Omega.cross(&Omega.cross(&self.S));
            f_x += R * g;
            h += self.S.cross(&a);
        }
        let f_psi = T.tr_mul(&h);
        Ok(Moving {
            quotients,
            T,
            R,
            Omega,
            L,
            a,
            g,
            h,
            f: Vector6::new(f_x.x, f_x.y, f_x.z, f_psi.x, f_psi.y, f_psi.z),
        })
    }

    /// f_acc and its tangents M, C and K; \[M04\] (119), (147), (152).
    ///
    /// # Errors
    /// [`ElementError::OutsideChart`] for ψ at 2π.
    #[inline]
    pub fn evaluate(&self, at: &PointMotion) -> Result<PointInertia, ElementError> {
        let on = self.moving(at)?;
        let (psi, q, T, J) = (&at.psi, &on.quotients, &on.T, &self.J);
        // A = TΨ̈ + ṪΨ̇ and Ω = TΨ̇ have the derivatives A_Ψ̇ = C₄, A_Ψ = C₅ + C₁(Ψ̈), Ω_Ψ = C₁(Ψ̇).
        let C1 = so3::C1(&at.psi_dot, psi, q);
        let C4 = so3::C4(&at.psi_dot, psi, q);
        let A_psi = so3::C5(&at.psi_dot, psi, q) + so3::C1(&at.psi_ddot, psi, q);
        // (152): D_Ω(Ω~JΩ) = Ω~J − (JΩ)~.
        let G = skew(&on.Omega) * J - skew(&on.L);
        let M = T.tr_mul(&(J * T));
        let C = T.tr_mul(&(G * T + J * C4));
        let mut K = G * C1 + J * A_psi;
        let mut out = PointInertia {
            f: on.f,
            M: Matrix6::zeros(),
            C: Matrix6::zeros(),
            K: Matrix6::zeros(),
        };
        for k in 0..3 {
            out.M[(k, k)] = self.m;
        }
        if self.is_eccentric() {
            let S = skew(&self.S);
            let RS = on.R * S;
            // D_Ω(Ω~Ω~S) = −(Ω~S)~ − Ω~S~.
            let W = skew(&on.Omega.cross(&self.S)) + skew(&on.Omega) * S;
            let M_x = RS * T * -1.0;
            put(&mut out.M, 0, 3, &M_x);
            put(&mut out.M, 3, 0, &M_x.transpose());
            put(&mut out.C, 0, 3, &-(on.R * (W * T) + RS * C4));
            // D_Ψ(R g) = −R g~ T and D_Ψ(Rᵀẍ) = (Rᵀẍ)~ T.
            let turned = skew(&on.g) * T + W * C1;
            put(&mut out.K, 0, 3, &-(on.R * turned + RS * A_psi));
            // S~(Rᵀẍ)~ T.
            K += S * (skew(&on.a) * T);
        }
        put(&mut out.M, 3, 3, &M);
        put(&mut out.C, 3, 3, &C);
        put(&mut out.K, 3, 3, &(so3::C2(&on.h, psi, q) + T.tr_mul(&K)));
        Ok(out)
    }
}

/// Writes a 3×3 block.
#[inline]
fn put(to: &mut Matrix6<f64>, row: usize, column: usize, block: &Matrix3<f64>) {
    to.fixed_view_mut::<3, 3>(row, column).copy_from(block);
}
