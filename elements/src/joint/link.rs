//! A joint behind its parent: pose, operator and geometric stiffness of the child, in closed form.
//!
//! With x, R of the parent, the pose (c, Q) of the child in its parent and δQ = \[b δq\] Q,
//!
//! ```text
//! ρ = R c,  x_c = x + ρ,  R_c = R Q,      δx_c = δx − ρ × δθ + α δq,   α = R ∂c/∂q
//!                                         δθ_c = δθ + β δq,            β = R b
//! ```
//!
//! and rotation vectors come in by δθ = Tᵀ δΨ on both sides: \[M04\] (207) for any joint. Derivatives of c
//! and Q are exact ones in the joint's own coordinates.

#![allow(non_snake_case)]

use super::{Joint, Pose};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use pullback_manifold::jet::{Hess, Moving};
use pullback_manifold::map::KinematicsMut;
use pullback_manifold::quotients::Quotients;
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::{self, Quaternion, quaternion, skew};

/// A value with its first two time derivatives.
pub(super) type Rates<T> = [T; 3];

/// A joint, and the position of its child in the parent in the reference configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Link<J, const D: usize> {
    pub joint: J,
    start: Vector3<f64>,
}

/// The rotation of a parent along a motion.
pub(super) struct Parent {
    psi: Vector3<f64>,
    R: Matrix3<f64>,
    /// Tᵀ.
    pub tangent: Rates<Matrix3<f64>>,
    /// Skew matrices of ω and ω̇.
    omega: [Matrix3<f64>; 2],
}

impl Parent {
    fn new([q, v, a]: [&[f64]; 3]) -> Self {
        let [psi, psi_dot, psi_ddot] = [q, v, a].map(rotation);
        let c = Quotients::new(psi.norm());
        let tangent = [
            so3::T(&psi, &c.tangent()),
            so3::T_dot(&psi_dot, &psi, &c),
            so3::T_ddot(&psi_dot, &psi_ddot, &psi, &c),
        ];
        let tangent = tangent.map(|T| T.transpose());
        let omega = tangent[0] * psi_dot;
        let omega_dot = tangent[0] * psi_ddot + tangent[1] * psi_dot;
        Self {
            psi,
            R: so3::R(&psi, &c.tangent()),
            tangent,
            omega: [skew(&omega), skew(&omega_dot)],
        }
    }

    /// Vectors that the parent carries, from components in its axes.
    fn carry<const N: usize>(&self, u: &Rates<SMatrix<f64, 3, N>>) -> Rates<SMatrix<f64, 3, N>> {
        let [u, u_dot, u_ddot] = u.each_ref().map(|u| self.R * u);
        let rate = self.omega[0] * u + u_dot;
        let second = self.omega[1] * u + self.omega[0] * (rate + u_dot) + u_ddot;
        [u, rate, second]
    }
}

/// The kinematics of a link: everything but the rotation vector of the child.
pub(super) struct Carried<const D: usize> {
    pub parent: Parent,
    pub rotation: Quaternion<f64>,
    rho: Rates<Vector3<f64>>,
    alpha: Rates<SMatrix<f64, 3, D>>,
    pub beta: Rates<SMatrix<f64, 3, D>>,
    /// Angular velocity of the child and its rate.
    pub omega: [Vector3<f64>; 2],
}

impl<J: Joint<D>, const D: usize> Link<J, D> {
    pub(super) fn new(joint: J) -> Self {
        let start = joint.pose(0.0, &SVector::zeros()).d;
        Self { joint, start }
    }

    fn pose(&self, t: f64, q: &[f64]) -> Pose<f64> {
        self.joint.pose(t, &own(q))
    }

    /// The quaternion of the child.
    pub(super) fn rotation(&self, t: f64, q: &[f64]) -> Quaternion<f64> {
        quaternion(&rotation(q)).product(&self.pose(t, q).rotation)
    }

    /// The least of the margin of the joint and another one, of the child's quaternion; not a number where
    /// one of them or the pose is none.
    pub(super) fn margin(
        &self,
        t: f64,
        q: &[f64],
        other: impl FnOnce(&Quaternion<f64>) -> f64,
    ) -> f64 {
        let margin = self.joint.margin(t, &own(q));
        if margin.is_nan() || margin <= 0.0 {
            return margin;
        }
        let relative = self.pose(t, q).rotation;
        if !is_unit(&relative) {
            return f64::NAN;
        }
        let other = other(&quaternion(&rotation(q)).product(&relative));
        if other.is_nan() {
            other
        } else {
            margin.min(other)
        }
    }

    pub(super) fn domain_error(&self, t: f64, q: &[f64]) -> Option<String> {
        let rotation = self.pose(t, q).rotation;
        let norm = rotation.dot(&rotation).sqrt();
        (norm.is_finite() && !is_unit(&rotation)).then(|| {
            format!("the quaternion of its pose has length {norm:.6}: make it a unit quaternion")
        })
    }

    pub(super) fn carried(&self, t: f64, motion: [&[f64]; 3]) -> Carried<D> {
        let parent = Parent::new(motion);
        let [q, v, a] = motion.map(own::<D>);
        let q = SVector::<Moving<D>, D>::from_fn(|i, _| Moving::variable([q[i], v[i], a[i]], i));
        let Pose { d, rotation } = self.joint.pose(Moving::given([t, 1.0, 0.0]), &q);
        let c = [0, 1, 2].map(|k| d.map(|d| d.x[k]));
        let c_q = [0, 1, 2].map(|k| SMatrix::from_fn(|i, j| d[i].g[k][j]));
        let of = |k: usize| part(&rotation, |x| x.x[k]);
        let [Q, Q_dot, Q_ddot] = [of(0), of(1), of(2)];
        let mut b = [SMatrix::<f64, 3, D>::zeros(); 3];
        for j in 0..D {
            let of = |k: usize| part(&rotation, |x| x.g[k][j]);
            let [g, g_dot, g_ddot] = [of(0), of(1), of(2)];
            b[0].set_column(j, &turn(&g, &Q));
            b[1].set_column(j, &(turn(&g_dot, &Q) + turn(&g, &Q_dot)));
            let mixed = turn(&g_dot, &Q_dot) * 2.0;
            b[2].set_column(j, &(turn(&g_ddot, &Q) + mixed + turn(&g, &Q_ddot)));
        }
        // The child turns against its parent by w; Q̇ Q̇* has no vector part.
        let w = [turn(&Q_dot, &Q), turn(&Q_ddot, &Q), Vector3::zeros()];
        let [relative, relative_dot, _] = parent.carry(&w);
        let axial = |A: &Matrix3<f64>| so3::axial(A);
        let omega = [
            axial(&parent.omega[0]) + relative,
            axial(&parent.omega[1]) + relative_dot,
        ];
        Carried {
            rotation: quaternion(&parent.psi).product(&Q),
            rho: parent.carry(&c),
            alpha: parent.carry(&c_q),
            beta: parent.carry(&b),
            omega,
            parent,
        }
    }

    /// Writes the rows of the position, as many orders as there is room for.
    pub(super) fn write_position(
        &self,
        at: &Carried<D>,
        motion: [&[f64]; 3],
        out: &mut [[&mut [f64]; 2]],
    ) {
        let starts = [self.start, Vector3::zeros(), Vector3::zeros()];
        let lever = at.rho.map(|rho| -skew(&rho));
        let turned = product(&lever, &at.parent.tangent);
        for (k, [x, B]) in out.iter_mut().enumerate() {
            let d = vector(motion[k], 0) + at.rho[k] - starts[k];
            x[..3].copy_from_slice(d.as_slice());
            put(B, 6, [0, 0], &unit(k));
            put(B, 6, [0, 3], &turned[k]);
            put(B, 6, [0, 6], &at.alpha[k]);
        }
    }

    /// K_σ of the force f and the moment m at the child, where the moment varies by −N δθ_c in its turn,
    /// into the first 6 + D columns and rows of K; the matrix has `n` rows.
    pub(super) fn write_stiffness(
        &self,
        (t, q): (f64, &[f64]),
        [f, m]: [&Vector3<f64>; 2],
        N: &Matrix3<f64>,
        (K, n): (&mut [f64], usize),
    ) {
        let psi = rotation(q);
        let quotients = Quotients::new(psi.norm());
        let tangent = quotients.tangent();
        let (R, T) = (so3::R(&psi, &tangent), so3::T(&psi, &tangent));
        let q = own::<D>(q);
        let q = SVector::<Hess<D>, D>::from_fn(|i, _| Hess::variable(q[i], i));
        let Pose { d, rotation } = self.joint.pose(Hess::constant(t), &q);
        let rho = R * d.map(|d| d.v);
        let alpha = R * SMatrix::<f64, 3, D>::from_fn(|i, j| d[i].g[j]);
        let Q = part(&rotation, |x| x.v);
        let gradient = |k: usize| part(&rotation, |x| x.g[k]);
        let mut beta = SMatrix::<f64, 3, D>::zeros();
        for k in 0..D {
            beta.set_column(k, &(R * turn(&gradient(k), &Q)));
        }
        // In the variations of the parent's rotation and of q.
        let K_tt = skew(f) * skew(&rho) + N;
        let K_tq = N * beta - skew(f) * alpha;
        let (f_own, m_own) = (R.tr_mul(f), R.tr_mul(m));
        let mut K_qq = beta.tr_mul(&(N * beta));
        for k in 0..D {
            for l in 0..D {
                let [i, j] = [k.max(l), k.min(l)];
                let bent = part(&rotation, |x| x.h[i][j]);
                let b_kl = turn(&bent, &Q) + turn(&gradient(k), &gradient(l));
                let c_kl = d.map(|d| d.h[i][j]);
                K_qq[(k, l)] += f_own.dot(&c_kl) + m_own.dot(&b_kl);
            }
        }
        let moment = rho.cross(f) + m;
        let K_pp = T * K_tt * T.transpose() + so3::C1(&moment, &psi, &quotients);
        let K_pq = T * K_tq;
        put(K, n, [3, 3], &((K_pp + K_pp.transpose()) * 0.5));
        put(K, n, [3, 6], &K_pq);
        put(K, n, [6, 3], &K_pq.transpose());
        put(K, n, [6, 6], &((K_qq + K_qq.transpose()) * 0.5));
    }
}

/// Three entries of a slice; zero where it has none, as velocities in statics.
pub(super) fn vector(x: &[f64], first: usize) -> Vector3<f64> {
    x.get(first..first + 3)
        .map_or_else(Vector3::zeros, Vector3::from_column_slice)
}

/// The rotation vector of the parent.
fn rotation(q: &[f64]) -> Vector3<f64> {
    vector(q, 3)
}

/// The coordinates of the joint.
pub(super) fn own<const D: usize>(q: &[f64]) -> SVector<f64, D> {
    q.get(6..6 + D)
        .map_or_else(SVector::zeros, SVector::from_column_slice)
}

/// Whether a quaternion is a rotation, up to rounding.
fn is_unit(rotation: &Quaternion<f64>) -> bool {
    (rotation.dot(rotation) - 1.0).abs() < 1e-9
}

/// One number of each entry of a quaternion.
fn part<S: Scalar>(of: &Quaternion<S>, number: impl Fn(&S) -> f64) -> Quaternion<f64> {
    Quaternion {
        w: number(&of.w),
        v: Vector3::from_fn(|i, _| number(&of.v[i])),
    }
}

/// 2 vec(a b*): the rotation vector by which a variation `a` turns a quaternion `b`.
fn turn(a: &Quaternion<f64>, b: &Quaternion<f64>) -> Vector3<f64> {
    a.product(&b.conjugate()).v * 2.0
}

/// A B with its rates.
pub(super) fn product<const N: usize>(
    [A, A_dot, A_ddot]: &Rates<Matrix3<f64>>,
    [B, B_dot, B_ddot]: &Rates<SMatrix<f64, 3, N>>,
) -> Rates<SMatrix<f64, 3, N>> {
    [
        A * B,
        A_dot * B + A * B_dot,
        A_ddot * B + A_dot * B_dot * 2.0 + A * B_ddot,
    ]
}

/// The identity, which does not move.
pub(super) fn unit(order: usize) -> Matrix3<f64> {
    Matrix3::from_diagonal_element(if order == 0 { 1.0 } else { 0.0 })
}

/// Coordinates and operators, order by order.
pub(super) fn orders<'a>(out: KinematicsMut<'a>) -> [[&'a mut [f64]; 2]; 3] {
    [
        [out.x, out.B],
        [out.x_dot, out.B_dot],
        [out.x_ddot, out.B_ddot],
    ]
}

/// Writes a block into a matrix of `n` rows, column by column.
pub(super) fn put<const M: usize, const N: usize>(
    into: &mut [f64],
    n: usize,
    [row, column]: [usize; 2],
    block: &SMatrix<f64, M, N>,
) {
    for (j, values) in block.column_iter().enumerate() {
        let first = (column + j) * n + row;
        into[first..first + M].copy_from_slice(values.as_slice());
    }
}
