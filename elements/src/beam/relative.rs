//! A frame relative to another one: a node of a geodesic element, or an end of a bushing.

use crate::blocks::{add_block, three};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use pullback_manifold::quotients::{InverseQuotients, Quotients};
use pullback_manifold::so3::{self, skew};

/// A rotation vector and its derived quantities.
pub(crate) struct Turn {
    pub psi: Vector3<f64>,
    pub quotients: Quotients,
    pub T: Matrix3<f64>,
}

impl Turn {
    pub(crate) fn new(psi: Vector3<f64>) -> Self {
        let quotients = Quotients::new(psi.norm());
        let T = so3::T(&psi, &quotients.tangent());
        Self { psi, quotients, T }
    }
}

/// log(R_rᵀ R) of two rotation vectors, less than a whole turn; these determine its branch.
pub(crate) fn turn_between(psi_r: &Vector3<f64>, psi: &Vector3<f64>) -> Vector3<f64> {
    let from = so3::quaternion(psi_r).conjugate();
    so3::log_quaternion(&from.product(&so3::quaternion(psi)))
}

/// Kinematic operator of one node: (δz, δϑ) = own (δd, δΨ) + reference (δd_r, δΨ_r), that is
/// δz = z_d (δd − δd_r) + z_r δΨ_r and δϑ = ϑ_Ψ δΨ − ϑ_r δΨ_r.
pub(crate) struct Operator {
    pub own: Matrix6<f64>,
    pub reference: Matrix6<f64>,
}

impl Operator {
    #[inline]
    pub(crate) fn new(
        z_d: &Matrix3<f64>,
        z_r: &Matrix3<f64>,
        theta_psi: &Matrix3<f64>,
        theta_r: &Matrix3<f64>,
    ) -> Self {
        let (mut own, mut reference) = (Matrix6::zeros(), Matrix6::zeros());
        for c in 0..3 {
            for r in 0..3 {
                own[(r, c)] = z_d[(r, c)];
                own[(3 + r, 3 + c)] = theta_psi[(r, c)];
                reference[(r, c)] = -z_d[(r, c)];
                reference[(r, 3 + c)] = z_r[(r, c)];
                reference[(3 + r, 3 + c)] = -theta_r[(r, c)];
            }
        }
        Self { own, reference }
    }
}

/// Position z and rotation vector ϑ of a node relative to the reference node, in its axes.
pub(crate) struct RelativePose {
    pub z: Vector3<f64>,
    pub theta: Vector3<f64>,
}

/// A node other than the reference, for the pull-back.
pub(crate) struct RelativeNode {
    pub turn: Turn,
    pub seen: RelativePose,
    pub inverse: InverseQuotients,
    pub T_inverse: Matrix3<f64>,
    pub theta_psi: Matrix3<f64>,
    pub theta_r: Matrix3<f64>,
    pub B: Operator,
}

impl RelativeNode {
    #[inline]
    pub(crate) fn new(
        turn: Turn,
        seen: RelativePose,
        reference: &Turn,
        R_t: &Matrix3<f64>,
    ) -> Self {
        let inverse = InverseQuotients::new(seen.theta.norm());
        let T_inverse = so3::T_inverse(&seen.theta, &inverse);
        let theta_psi = T_inverse * turn.T;
        let theta_r = T_inverse.transpose() * reference.T;
        let z_r = skew(&seen.z) * reference.T;
        Self {
            B: Operator::new(R_t, &z_r, &theta_psi, &theta_r),
            turn,
            seen,
            inverse,
            T_inverse,
            theta_psi,
            theta_r,
        }
    }

    /// (ż, ϑ̇) at the velocities of this node and the reference node.
    pub(crate) fn rates(&self, v: &[f64], v_r: &[f64]) -> Vector6<f64> {
        let [v, v_r] = [v, v_r].map(|v| Vector6::from_column_slice(&v[..6]));
        self.B.own * v + self.B.reference * v_r
    }

    /// The time derivative of the operator at rates (ż, ϑ̇), and rates of the two rotation vectors.
    pub(crate) fn B_dot(
        &self,
        rates: &Vector6<f64>,
        reference: &Turn,
        psi_dot: &Vector3<f64>,
        psi_r_dot: &Vector3<f64>,
    ) -> Operator {
        let [z_dot, theta_dot] = [0, 3].map(|k| three(rates.as_slice(), k));
        let dot = |turn: &Turn, psi_dot| so3::T_dot(psi_dot, &turn.psi, &turn.quotients);
        let (T_dot, T_r_dot) = (dot(&self.turn, psi_dot), dot(reference, psi_r_dot));
        let (T_inverse, theta) = (&self.T_inverse, &self.seen.theta);
        // d/dt T⁻¹ = −T⁻¹ Ṫ T⁻¹.
        let c = Quotients::new(theta.norm());
        let T_inverse_dot = -T_inverse * so3::T_dot(&theta_dot, theta, &c) * T_inverse;
        let z_d = self.B.own.fixed_view::<3, 3>(0, 0);
        Operator::new(
            &(-skew(&(reference.T * psi_r_dot)) * z_d),
            &(skew(&z_dot) * reference.T + skew(&self.seen.z) * T_r_dot),
            &(T_inverse_dot * self.turn.T + T_inverse * T_dot),
            &(T_inverse_dot.transpose() * reference.T + T_inverse.transpose() * T_r_dot),
        )
    }

    /// Adds K_σ, the derivative of Bᵀ(n, m) with the forces n and m of z and ϑ fixed, to a matrix of `size` rows. The
    /// coordinates of this node begin at i, those of the reference at r.
    pub(crate) fn add_geometric(
        &self,
        reference: &Turn,
        [n, m]: [Vector3<f64>; 2],
        out: &mut [f64],
        size: usize,
        [i, r]: [usize; 2],
    ) {
        let (turn, seen, T_r) = (&self.turn, &self.seen, &reference.T);
        // Moments of δΘ of this node and of the reference.
        let own = self.T_inverse.tr_mul(&m);
        let far = n.cross(&seen.z) - self.T_inverse * m;
        // D_ϑ(T⁻ᵀ m); as T⁻¹ = T⁻ᵀ + ϑ~, that of T⁻¹ m is C₆ − m~.
        let C6 = so3::C6(&m, &seen.theta, &self.inverse);
        let left = turn.T.tr_mul(&C6);
        let own = so3::C2(&own, &turn.psi, &turn.quotients) + left * self.theta_psi;
        let mixed = -left * self.theta_r;
        let n = skew(&n);
        let far = so3::C2(&far, &reference.psi, &reference.quotients)
            + T_r.tr_mul(&(n * (skew(&seen.z) * T_r) + (C6 - skew(&m)) * self.theta_r));
        // −R_r n~ T_r.
        let d = -self.B.own.fixed_view::<3, 3>(0, 0).tr_mul(&(n * T_r));
        add_block(out, size, i + 3, i + 3, &own);
        add_block(out, size, r + 3, r + 3, &far);
        for (row, column, block) in [(i + 3, r + 3, mixed), (i, r + 3, d), (r, r + 3, -d)] {
            add_block(out, size, row, column, &block);
            add_block(out, size, column, row, &block.transpose());
        }
    }
}

/// The 6×6 block of nodes i and j of an n×n matrix, times a factor.
#[inline]
pub(crate) fn block(K: &[f64], n: usize, i: usize, j: usize, factor: f64) -> Matrix6<f64> {
    let mut out = Matrix6::zeros();
    for c in 0..6 {
        let start = 6 * i + (6 * j + c) * n;
        for (o, K) in out.column_mut(c).iter_mut().zip(&K[start..start + 6]) {
            *o = factor * K;
        }
    }
    out
}
