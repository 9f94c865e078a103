//! Inertia of a frame with mass: a rigid body, or a cross-section per unit length.
//!
//! With material quantities (components in the initial frame) Ω = TΨ̇, A = TΨ̈ + ṪΨ̇, g = Rᵀẍ, the
//! mass m, its first moment S = m c and its moments J about the frame's origin:
//!
//! ```text
//! kinetic energy   ½ m ẋ·ẋ + ẋ·R(Ω×S) + ½ Ω·JΩ
//! f_acc = ( m ẍ + R ℓ ;  Tᵀ h ),   ℓ = A×S + Ω×(Ω×S),   h = J A + Ω×JΩ + S×g       [M04] (119)
//! ```
//!
//! and the tangents are those of \[M04\] (147), (152) with the terms of S.

use crate::Asymmetry;
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use pullback_manifold::quotients::{Quotients, TangentQuotients};
use pullback_manifold::so3::{self, skew};
use pullback_manifold::system::Weights;

/// Mass, first moment and moments of inertia of a body about a frame's origin (or of a
/// cross-section, per unit length, about its axis), components in axes fixed in the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inertia {
    /// Mass m (Aρ of a section).
    pub mass: f64,
    /// First moment S = m c, c the position of the mass centre.
    pub S: Vector3<f64>,
    /// Moments of inertia J about the origin, 3×3, symmetric.
    pub J: Matrix3<f64>,
}

/// Error of a mass or an inertia.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "each message says what its variant is")]
#[non_exhaustive]
pub enum InertiaError {
    #[error("{quantity} must be finite, got {value}")]
    NotFinite { quantity: &'static str, value: f64 },
    #[error("the mass must be {required}, got {mass}")]
    Mass { required: &'static str, mass: f64 },
    #[error("the inertia must be symmetric, but {0}")]
    NotSymmetric(Asymmetry),
    #[error(
        "the inertia must be positive semidefinite, but its principal moments about the centre of mass are {principal:?}"
    )]
    Negative {
        /// Principal moments of inertia, increasing.
        principal: [f64; 3],
    },
    #[error(
        "no body has the principal moments of inertia {principal:?} about its centre of mass: the \
         largest exceeds the sum of the others"
    )]
    Triangle {
        /// Principal moments of inertia, increasing.
        principal: [f64; 3],
    },
    #[error("a body needs mass or inertia, both are zero")]
    Massless,
}

/// Motion of a frame: Ψ and its two rates, ẍ of its origin, and Ω and A.
pub(crate) struct FrameMotion {
    pub psi: Vector3<f64>,
    pub x_ddot: Vector3<f64>,
    pub quotients: Quotients,
    /// R(Ψ); zero without an eccentric mass.
    pub R: Matrix3<f64>,
    pub T: Matrix3<f64>,
    pub Omega: Vector3<f64>,
    pub A: Vector3<f64>,
    psi_dot: Vector3<f64>,
    psi_ddot: Vector3<f64>,
}

impl FrameMotion {
    /// A motion with accelerations increased by α times the velocities: inertia is linear in
    /// accelerations, so this adds the drag α M ẋ.
    /// R is needed for an `eccentric` mass only.
    #[inline(always)]
    pub fn new(
        psi: Vector3<f64>,
        [x_dot, psi_dot]: [Vector3<f64>; 2],
        [x_ddot, psi_ddot]: [Vector3<f64>; 2],
        alpha: f64,
        eccentric: bool,
    ) -> Self {
        let psi_ddot = psi_ddot + psi_dot * alpha;
        let quotients = Quotients::new(psi.norm());
        let c = quotients.tangent();
        let T = so3::T(&psi, &c);
        Self {
            x_ddot: x_ddot + x_dot * alpha,
            R: match eccentric {
                true => so3::R(&psi, &c),
                false => Matrix3::zeros(),
            },
            Omega: T * psi_dot,
            A: T * psi_ddot + so3::T_dot_psi_dot(&psi_dot, &psi, &quotients),
            psi,
            psi_dot,
            psi_ddot,
            quotients,
            T,
        }
    }

    /// A×S + Ω×(Ω×S), material: the mass times the acceleration of its centre relative to the origin.
    #[inline(always)]
    pub fn l(&self, S: &Vector3<f64>) -> Vector3<f64> {
        self.A.cross(S) + self.Omega.cross(&self.Omega.cross(S))
    }

    /// Variations of Ω and A with (Ψ, Ψ̇, Ψ̈), with the weights of a tangent: δΩ = C₁ δΨ + T δΨ̇,
    /// δA = (C₅ + C₁(Ψ̈)) δΨ + C₄ δΨ̇ + T δΨ̈.
    #[inline(always)]
    pub fn varied(&self, w: &Weights) -> [Matrix3<f64>; 2] {
        if w.K == 0.0 && w.C == 0.0 {
            return [Matrix3::zeros(), self.T * w.M];
        }
        let (psi, psi_dot, c) = (&self.psi, &self.psi_dot, &self.quotients);
        [
            so3::C1(&(psi_dot * w.K), psi, c) + self.T * w.C,
            so3::A_varied([w.K, w.C, w.M], psi_dot, &self.psi_ddot, psi, c),
        ]
    }
}

/// D_Ω (Ω×(Ω×S)), 3×3.
pub(crate) fn centrifugal(Omega: &Vector3<f64>, S: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::from_diagonal_element(Omega.dot(S)) + Omega * S.transpose()
        - S * Omega.transpose() * 2.0
}

fn stack(a: &Vector3<f64>, b: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(a.x, a.y, a.z, b.x, b.y, b.z)
}

/// Round-off of principal moments, relative to the largest moment from which they were computed.
const ROUND_OFF: f64 = 1e-9;

/// The principal moments about the centre, increasing. Refuses a mass, the position or first moment of its centre, and
/// an inertia `J` that are negative or not finite; the inertia about the centre is J + `shift`.
pub(crate) fn check(
    mass: f64,
    (of_center, center): (&'static str, &Vector3<f64>),
    J: &Matrix3<f64>,
    shift: &Matrix3<f64>,
) -> Result<[f64; 3], InertiaError> {
    let finite = |quantity, values: &[f64]| match values.iter().find(|x| !x.is_finite()) {
        Some(&value) => Err(InertiaError::NotFinite { quantity, value }),
        None => Ok(()),
    };
    finite("the mass", &[mass])?;
    finite(of_center, center.as_slice())?;
    finite("the inertia", J.as_slice())?;
    if mass < 0.0 {
        let required = "zero or positive";
        return Err(InertiaError::Mass { required, mass });
    }
    let size = J.amax();
    if let Some(asymmetry) = Asymmetry::of(J, |_, _| 1e-12 * size) {
        return Err(InertiaError::NotSymmetric(asymmetry));
    }
    let mut principal: [f64; 3] = (J + shift).symmetric_eigenvalues().into();
    principal.sort_by(f64::total_cmp);
    if principal[0] < -ROUND_OFF * size {
        return Err(InertiaError::Negative { principal });
    }
    Ok(principal)
}

impl Inertia {
    /// Inertia with the mass centre at `c` and the tensor `J` about the mass centre: by the
    /// parallel-axis theorem the tensor about the origin is J − m c~c~.
    #[must_use]
    pub fn about_centre(mass: f64, c: Vector3<f64>, J: Matrix3<f64>) -> Self {
        let S = c * mass;
        Self {
            mass,
            S,
            J: J - skew(&S) * skew(&c),
        }
    }

    /// The same inertia, validated: finite, symmetric and not negative. Of a section it may be neglected in part, so
    /// that J₁ ≠ J₂ + J₃.
    ///
    /// # Errors
    /// [`InertiaError`].
    pub fn checked(mut self) -> Result<Self, InertiaError> {
        let shift = match self.mass > 0.0 {
            true => skew(&self.S) * skew(&self.S) / self.mass,
            false => Matrix3::zeros(),
        };
        let S = ("the first moment", &self.S);
        check(self.mass, S, &self.J, &shift)?;
        self.J = (self.J + self.J.transpose()) * 0.5;
        Ok(self)
    }

    /// The same inertia with components in the axes rotated by R₀.
    #[must_use]
    pub fn rotated(&self, R0: &Matrix3<f64>) -> Self {
        Self {
            mass: self.mass,
            S: R0 * self.S,
            J: R0 * self.J * R0.transpose(),
        }
    }

    /// Kinetic energy at velocities ẋ (global) and Ψ̇.
    #[must_use]
    pub fn kinetic_energy(
        &self,
        x_dot: &Vector3<f64>,
        psi: &Vector3<f64>,
        psi_dot: &Vector3<f64>,
    ) -> f64 {
        let c = TangentQuotients::new(psi.norm_squared());
        let Omega = so3::spun(psi, psi_dot, &c);
        let mut energy = self.mass * x_dot.norm_squared() + Omega.dot(&(self.J * Omega));
        if self.is_eccentric() {
            energy += 2.0 * so3::turned(psi, &Omega.cross(&self.S), &c).dot(x_dot);
        }
        0.5 * energy
    }

    /// Whether the inertia is zero.
    pub fn is_zero(&self) -> bool {
        *self == Self::default()
    }

    /// Whether the mass centre is not the frame's origin.
    pub(crate) fn is_eccentric(&self) -> bool {
        self.S != Vector3::zeros()
    }

    /// J A + Ω×JΩ + S×g, material.
    #[inline]
    fn h(&self, at: &FrameMotion) -> Vector3<f64> {
        let h = self.J * at.A + at.Omega.cross(&(self.J * at.Omega));
        match self.is_eccentric() {
            true => h + self.S.cross(&at.R.tr_mul(&at.x_ddot)),
            false => h,
        }
    }

    /// f_acc over (x, Ψ).
    #[inline]
    pub(crate) fn force(&self, at: &FrameMotion) -> Vector6<f64> {
        let mut f = at.x_ddot * self.mass;
        if self.is_eccentric() {
            f += at.R * at.l(&self.S);
        }
        stack(&f, &at.T.tr_mul(&self.h(at)))
    }

    /// M alone, for momenta and kinetic energies.
    #[inline]
    pub(crate) fn mass_matrix(&self, at: &FrameMotion) -> Matrix6<f64> {
        let (Self { mass, S, J }, T) = (self, &at.T);
        let mut M = Matrix6::zeros();
        for k in 0..3 {
            M[(k, k)] = *mass;
        }
        put(&mut M, 3, 3, &T.tr_mul(&(J * T)));
        if self.is_eccentric() {
            let B = at.R * skew(S) * T * -1.0;
            put(&mut M, 0, 3, &B);
            put(&mut M, 3, 0, &B.transpose());
        }
        M
    }

    /// The exact tangent of f_acc over (x, Ψ): K, C and M with the given weights.
    #[inline]
    pub(crate) fn tangent(&self, at: &FrameMotion, weights: Weights) -> Matrix6<f64> {
        let Self { mass, S, J } = self;
        let FrameMotion { R, T, Omega, .. } = at;
        let Weights { K, M, .. } = weights;
        let [Omega_q, A_q] = at.varied(&weights);
        // D_Ω (Ω×JΩ).
        let H = skew(Omega) * J - skew(&(J * Omega));
        let mut h_q = H * Omega_q + J * A_q;
        let mut tangent = Matrix6::zeros();
        if self.is_eccentric() {
            let S_skew = skew(S);
            h_q += S_skew * skew(&R.tr_mul(&at.x_ddot)) * T * K;
            let l_q = centrifugal(Omega, S) * Omega_q - S_skew * A_q - skew(&at.l(S)) * T * K;
            put(&mut tangent, 0, 3, &(R * l_q));
            put(&mut tangent, 3, 0, &(T.tr_mul(&S_skew) * R.transpose() * M));
        }
        for k in 0..3 {
            tangent[(k, k)] = mass * M;
        }
        let turning = so3::C2(&(self.h(at) * K), &at.psi, &at.quotients) + T.tr_mul(&h_q);
        put(&mut tangent, 3, 3, &turning);
        tangent
    }
}

#[inline]
fn put(M: &mut Matrix6<f64>, row: usize, column: usize, block: &Matrix3<f64>) {
    M.fixed_view_mut::<3, 3>(row, column).copy_from(block);
}
