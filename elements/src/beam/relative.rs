//! A node of a geodesic element relative to its reference node, and blocks of matrices over nodes.

#![allow(non_snake_case)]

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use pullback_manifold::quotients::{InverseQuotients, Quotients};
use pullback_manifold::so3::{self, skew};

/// Three entries of a slice.
pub(super) fn three(x: &[f64], at: usize) -> Vector3<f64> {
    Vector3::new(x[at], x[at + 1], x[at + 2])
}

/// Adds a 3×3 block to an n×n matrix, column by column.
#[inline]
pub(super) fn add_block(out: &mut [f64], n: usize, row: usize, column: usize, A: &Matrix3<f64>) {
    for c in 0..3 {
        let start = row + (column + c) * n;
        for (o, a) in out[start..start + 3].iter_mut().zip(A.column(c).iter()) {
            *o += a;
        }
    }
}

/// A rotation vector and its derived quantities.
pub(super) struct Turn {
    pub psi: Vector3<f64>,
    pub quotients: Quotients,
    pub T: Matrix3<f64>,
}

impl Turn {
    pub(super) fn new(psi: Vector3<f64>) -> Self {
        let quotients = Quotients::new(psi.norm());
        let T = so3::T(&psi, &quotients.tangent());
        Self { psi, quotients, T }
    }
}

/// Kinematic operator of one node: (δz, δϑ) = own (δd, δΨ) + reference (δd_r, δΨ_r), that is
/// δz = z_d (δd − δd_r) + z_r δΨ_r and δϑ = ϑ_Ψ δΨ − ϑ_r δΨ_r.
pub(super) struct Operator {
    pub own: Matrix6<f64>,
    pub reference: Matrix6<f64>,
}

impl Operator {
    #[inline]
    pub(super) fn new(
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

/// A node relative to the reference node.
pub(super) struct Relative {
    pub z: Vector3<f64>,
    pub theta: Vector3<f64>,
}

/// A node other than the reference, for the pull-back.
pub(super) struct Node {
    pub turn: Turn,
    pub seen: Relative,
    pub inverse: InverseQuotients,
    pub T_inverse: Matrix3<f64>,
    pub theta_psi: Matrix3<f64>,
    pub theta_r: Matrix3<f64>,
    pub B: Operator,
}

impl Node {
    #[inline]
    pub(super) fn new(turn: Turn, seen: Relative, reference: &Turn, R_t: &Matrix3<f64>) -> Self {
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
    pub(super) fn rates(&self, v: &[f64], v_r: &[f64]) -> Vector6<f64> {
        let [v, v_r] = [v, v_r].map(|v| Vector6::from_column_slice(&v[..6]));
        self.B.own * v + self.B.reference * v_r
    }

    /// The time derivative of the operator.
    pub(super) fn B_dot(&self, reference: &Turn, v: &[f64], v_r: &[f64]) -> Operator {
        let rates = self.rates(v, v_r);
        let [z_dot, theta_dot] = [three(rates.as_slice(), 0), three(rates.as_slice(), 3)];
        let dot = |turn: &Turn, v| so3::T_dot(&three(v, 3), &turn.psi, &turn.quotients);
        let (T_dot, T_r_dot) = (dot(&self.turn, v), dot(reference, v_r));
        let (T_inverse, theta) = (&self.T_inverse, &self.seen.theta);
        // d/dt T⁻¹ = −T⁻¹ Ṫ T⁻¹.
        let c = Quotients::new(theta.norm());
        let T_inverse_dot = -T_inverse * so3::T_dot(&theta_dot, theta, &c) * T_inverse;
        let z_d = self.B.own.fixed_view::<3, 3>(0, 0);
        Operator::new(
            &(-skew(&(reference.T * three(v_r, 3))) * z_d),
            &(skew(&z_dot) * reference.T + skew(&self.seen.z) * T_r_dot),
            &(T_inverse_dot * self.turn.T + T_inverse * T_dot),
            &(T_inverse_dot.transpose() * reference.T + T_inverse.transpose() * T_r_dot),
        )
    }
}

/// The 6×6 block of nodes i and j of an n×n matrix, times a factor.
#[inline]
pub(super) fn block(K: &[f64], n: usize, i: usize, j: usize, factor: f64) -> Matrix6<f64> {
    let mut out = Matrix6::zeros();
    for c in 0..6 {
        let start = 6 * i + (6 * j + c) * n;
        for (o, K) in out.column_mut(c).iter_mut().zip(&K[start..start + 6]) {
            *o = factor * K;
        }
    }
    out
}

/// Adds the 6×6 block of nodes i and j to an n×n matrix.
#[inline]
pub(super) fn add_nodes(out: &mut [f64], n: usize, i: usize, j: usize, A: &Matrix6<f64>) {
    for c in 0..6 {
        let start = 6 * i + (6 * j + c) * n;
        for (o, a) in out[start..start + 6].iter_mut().zip(A.column(c).iter()) {
            *o += a;
        }
    }
}
