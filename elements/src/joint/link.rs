//! Pose, operator and geometric stiffness of the child of a joint, in closed form.
//!
//! With x, R of the parent, the pose (c, Q) of the child in its parent, where c includes the position of the joint,
//! and δQ = \[b δq\] Q,
//!
//! ```text
//! ρ = R c,  x_c = x + ρ,  R_c = R Q,      δx_c = δx − ρ × δθ + α δq,   α = R ∂c/∂q
//!                                         δθ_c = δθ + β δq,            β = R b
//! ```
//!
//! \[M04\] (207) for any joint, in the variations of poses ([`ToPose`](pullback_manifold::map::ToPose)).
//! Derivatives of c and Q are exact ones in the joint's own coordinates.

use super::{Joint, Pose};
use crate::blocks::three_or_zero;
use nalgebra::{Matrix3, SVector, Vector3};
use pullback_manifold::domain::{CHART_EDGE, DomainError};
use pullback_manifold::jet::{Grad, Hess, Moving};
use pullback_manifold::map::pose::orientation;
use pullback_manifold::map::write_block;
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::{Quaternion, skew};

/// A value with its first two time derivatives.
type Rates<T> = [T; 3];

/// A joint at a position in the axes of its parent, and the position of its child there in the reference
/// configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Link<J, const D: usize> {
    pub joint: J,
    position: Vector3<f64>,
    start: Vector3<f64>,
}

/// The rotation of a parent along a motion.
struct Parent {
    turn: Quaternion<f64>,
    R: Matrix3<f64>,
    omega: [Vector3<f64>; 2],
}

impl Parent {
    fn new([q, v, a]: [&[f64]; 3]) -> Self {
        let turn = orientation(q);
        Self {
            turn,
            R: turn.rotation(),
            omega: [v, a].map(|x| three_or_zero(x, 3)),
        }
    }

    /// A vector and its rates in the fixed frame, from components in the axes of the parent.
    #[inline]
    fn carry(&self, u: &Rates<Vector3<f64>>) -> Rates<Vector3<f64>> {
        let zero = Vector3::zeros();
        // Most axes are constant in the parent, and most joints have none for some of them.
        let constant = u[1] == zero && u[2] == zero;
        if constant && u[0] == zero {
            return [zero; 3];
        }
        let [omega, omega_dot] = &self.omega;
        let [u, u_dot, u_ddot] = match constant {
            true => [self.R * u[0], zero, zero],
            false => u.map(|u| self.R * u),
        };
        let rate = omega.cross(&u) + u_dot;
        let second = omega_dot.cross(&u) + omega.cross(&(rate + u_dot)) + u_ddot;
        [u, rate, second]
    }
}

/// The kinematics of a link along a motion.
pub(super) struct Carried<const D: usize> {
    /// Position, orientation, and the twist with its rate.
    x: Rates<Vector3<f64>>,
    pub turn: Quaternion<f64>,
    omega: [Vector3<f64>; 2],
    rho: Rates<Vector3<f64>>,
    /// α and β, by columns.
    own: [[Rates<Vector3<f64>>; 2]; D],
}

impl<J: Joint<D>, const D: usize> Link<J, D> {
    pub(super) fn new(joint: J, position: Vector3<f64>) -> Self {
        let start = position + joint.pose(0.0, &SVector::zeros()).d;
        Self {
            joint,
            position,
            start,
        }
    }

    /// The domain of the joint, where the rotation of its pose is one.
    pub(super) fn domain(&self, t: f64, q: &[f64]) -> Result<f64, DomainError> {
        let q = own(q);
        let margin = self.joint.domain(t, &q)?;
        let rotation = self.joint.pose(t, &q).rotation;
        if is_unit(&rotation) {
            return Ok(margin);
        }
        let norm = rotation.dot(&rotation).sqrt();
        Err(match norm.is_finite() {
            true => DomainError::Undefined(format!(
                "the quaternion of its pose has length {norm:.12}: make it a unit quaternion"
            )),
            false if q.iter().all(|q| q.is_finite()) => {
                DomainError::Undefined("its pose is not finite".to_owned())
            }
            false => DomainError::Beyond {
                limit: CHART_EDGE,
                margin: f64::NAN,
            },
        })
    }

    pub(super) fn freeze_piece(&mut self, at: Option<(f64, &[f64])>) {
        let at = at.map(|(t, q)| (t, own(q)));
        self.joint.freeze_piece(at.as_ref().map(|(t, q)| (*t, q)));
    }

    /// The kinematics along a motion.
    pub(super) fn carried(&self, t: f64, motion: [&[f64]; 3]) -> Carried<D> {
        let parent = Parent::new(motion);
        let [q, v, a] = motion.map(own::<D>);
        let q = SVector::<Moving<D>, D>::from_fn(|i, _| Moving::variable([q[i], v[i], a[i]], i));
        let Pose { d, rotation } = self.joint.pose(Moving::given([t, 1.0, 0.0]), &q);
        let mut c = [0, 1, 2].map(|k| d.map(|d| d.x[k]));
        c[0] += self.position;
        let of = |k: usize| part(&rotation, |x| x.x[k]);
        let [Q, Q_dot, Q_ddot] = [of(0), of(1), of(2)];
        let own = std::array::from_fn(|j| {
            let c_q = [0, 1, 2].map(|k| d.map(|d| d.g[k][j]));
            let of = |k: usize| part(&rotation, |x| x.g[k][j]);
            let [g, g_dot, g_ddot] = [of(0), of(1), of(2)];
            let b = [
                turn(&g, &Q),
                turn(&g_dot, &Q) + turn(&g, &Q_dot),
                turn(&g_ddot, &Q) + turn(&g_dot, &Q_dot) * 2.0 + turn(&g, &Q_ddot),
            ];
            [parent.carry(&c_q), parent.carry(&b)]
        });
        // The child turns against its parent by w; Q̇ Q̇* has no vector part.
        let w = [turn(&Q_dot, &Q), turn(&Q_ddot, &Q), Vector3::zeros()];
        let [relative, relative_dot, _] = parent.carry(&w);
        let rho = parent.carry(&c);
        let starts = [self.start, Vector3::zeros(), Vector3::zeros()];
        Carried {
            x: std::array::from_fn(|k| three_or_zero(motion[k], 0) + rho[k] - starts[k]),
            turn: parent.turn.product(&Q),
            omega: [parent.omega[0] + relative, parent.omega[1] + relative_dot],
            rho,
            own,
        }
    }

    /// The same at rest.
    pub(super) fn carried_at_rest(&self, t: f64, q: &[f64]) -> Carried<D> {
        let turn_of_parent = orientation(q);
        let R = turn_of_parent.rotation();
        let still = |u: Vector3<f64>| [u, Vector3::zeros(), Vector3::zeros()];
        let own = own::<D>(q);
        let own = SVector::<Grad<f64, D>, D>::from_fn(|i, _| Grad::variable(own[i], i));
        let Pose { d, rotation } = self.joint.pose(Grad::constant(t), &own);
        let Q = part(&rotation, |x| x.v);
        let rho = R * (self.position + d.map(|d| d.v));
        Carried {
            x: still(three_or_zero(q, 0) + rho - self.start),
            turn: turn_of_parent.product(&Q),
            omega: [Vector3::zeros(); 2],
            rho: still(rho),
            own: std::array::from_fn(|j| {
                let b = turn(&part(&rotation, |x| x.g[j]), &Q);
                [still(R * d.map(|d| d.g[j])), still(R * b)]
            }),
        }
    }

    /// Writes K_σ of the force f and the moment m at the child into the first 6 + D columns and rows of K; the
    /// matrix has `n` rows.
    pub(super) fn write_stiffness(
        &self,
        (t, q): (f64, &[f64]),
        [f, m]: [&Vector3<f64>; 2],
        (K, n): (&mut [f64], usize),
    ) {
        let R = orientation(q).rotation();
        let q = own::<D>(q);
        let q = SVector::<Hess<D>, D>::from_fn(|i, _| Hess::coordinate(q[i], i));
        let Pose { d, rotation } = self.joint.pose(Hess::constant(t), &q);
        let rho = R * (self.position + d.map(|d| d.value));
        let Q = part(&rotation, |x| x.value);
        let gradient = |k: usize| part(&rotation, |x| x.x[k]);
        let (f_own, m_own) = (R.tr_mul(f), R.tr_mul(m));
        write_block(K, n, [3, 3], &(skew(f) * skew(&rho)));
        for k in 0..D {
            let alpha = R * d.map(|d| d.x[k]);
            let beta = R * turn(&gradient(k), &Q);
            write_block(K, n, [3, 6 + k], &alpha.cross(f));
            let row = alpha.cross(f) + beta.cross(m);
            write_block(K, n, [6 + k, 3], &row.transpose());
            for l in 0..D {
                let [i, j] = [k.max(l), k.min(l)];
                let bent = part(&rotation, |x| x.xx[i][j]);
                let b_kl = turn(&bent, &Q) + turn(&gradient(k), &gradient(l));
                let c_kl = d.map(|d| d.xx[i][j]);
                K[6 + k + (6 + l) * n] = f_own.dot(&c_kl) + m_own.dot(&b_kl);
            }
        }
    }
}

impl<const D: usize> Carried<D> {
    /// Writes the rows of the position, as many orders as there is room for.
    pub(super) fn write_position(&self, out: &mut [[&mut [f64]; 2]]) {
        for (k, [x, B]) in out.iter_mut().enumerate() {
            x[..3].copy_from_slice(self.x[k].as_slice());
            write_block(B, 6, [0, 0], &unit(k));
            write_block(B, 6, [0, 3], &-skew(&self.rho[k]));
            self.write_own(B, 0, k);
        }
    }

    /// Writes the rows of the rotation, as many orders as there is room for.
    pub(super) fn write_rotation(&self, out: &mut [[&mut [f64]; 2]]) {
        let turn = [self.turn.rodrigues(), self.omega[0], self.omega[1]];
        for (k, [x, B]) in out.iter_mut().enumerate() {
            x[3..].copy_from_slice(turn[k].as_slice());
            write_block(B, 6, [3, 0], &Matrix3::zeros());
            write_block(B, 6, [3, 3], &unit(k));
            self.write_own(B, 1, k);
        }
    }

    /// Rows of the joint's own columns: α (0) or β (1).
    fn write_own(&self, B: &mut [f64], part: usize, order: usize) {
        for (own, to) in self.own.iter().zip(B[36..].chunks_exact_mut(6)) {
            to[3 * part..3 * part + 3].copy_from_slice(own[part][order].as_slice());
        }
    }
}

/// The coordinates of the joint.
fn own<const D: usize>(q: &[f64]) -> SVector<f64, D> {
    q.get(6..6 + D)
        .map_or_else(SVector::zeros, SVector::from_column_slice)
}

/// Whether a quaternion is a rotation, up to rounding.
fn is_unit(rotation: &Quaternion<f64>) -> bool {
    (rotation.dot(rotation) - 1.0).abs() < 1e-9
}

/// One number of each entry of a quaternion.
#[inline]
fn part<S: Scalar>(of: &Quaternion<S>, number: impl Fn(&S) -> f64) -> Quaternion<f64> {
    Quaternion {
        w: number(&of.w),
        v: Vector3::from_fn(|i, _| number(&of.v[i])),
    }
}

/// 2 vec(a b*): the rotation vector of a variation `a` of a quaternion `b`.
#[inline]
fn turn(a: &Quaternion<f64>, b: &Quaternion<f64>) -> Vector3<f64> {
    (a.v * b.w - b.v * a.w - a.v.cross(&b.v)) * 2.0
}

/// The identity, and its rates, which are zero.
pub(super) fn unit(order: usize) -> Matrix3<f64> {
    Matrix3::from_diagonal_element(if order == 0 { 1.0 } else { 0.0 })
}
