//! The equations that two frames coincide.

use crate::blocks::{three, three_or_zero};
use crate::joint::Pose;
use nalgebra::{Matrix3, SVector, Vector3};
use pullback_manifold::map::pose::orientation;
use pullback_manifold::map::{Map, Order, Parametrization, write_block};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::skew;

/// Two coinciding frames: the gap to frame a in the axes of frame b, and twice the vector part of
/// the quaternion with a positive scalar part that rotates b to a; independent of the branches of
/// the rotation vectors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::model) struct Coincide {
    /// From b to a in the reference configuration.
    pub apart: Vector3<f64>,
}

impl Map<12, 6> for Coincide {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 12>) -> SVector<S, 6> {
        let (a, b) = (Pose::of(q, 0), Pose::of(q, 6));
        let back = b.rotation.conjugate();
        let gap = back.rotate(&(a.d - b.d + self.apart.map(S::constant)));
        let turn = back.product(&a.rotation);
        let turn = turn.v * S::constant(2.0_f64.copysign(turn.w.re()));
        SVector::<S, 6>::new(gap.x, gap.y, gap.z, turn.x, turn.y, turn.z)
    }
}

/// The same equations of the poses of the two frames, in closed form.
///
/// With R of frame b, g the gap, (w, v) the quaternion, u = Rᵀ(δθ_a − δθ_b) and L = w − v~,
///
/// ```text
/// δg = Rᵀ(δx_a − δx_b) + g × Rᵀδθ_b,   2 δv = L u,   2 δw = −v·u
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CoincidePoses(pub Coincide);

/// Two poses along a motion, in the axes of the second one, to the second order.
struct Apart {
    R: Matrix3<f64>,
    /// g and v with their rates, w with its rates.
    g: [Vector3<f64>; 3],
    w: [f64; 3],
    v: [Vector3<f64>; 3],
    /// Angular velocity of the axes and its rate.
    omega: [Vector3<f64>; 2],
}

/// A matrix in fixed components on the right, with its rates: A Rᵀ where Rᵀ˙ = −Ω~ Rᵀ.
fn turned(A: [Matrix3<f64>; 3], at: &Apart) -> [Matrix3<f64>; 3] {
    let [spin, spin_dot] = at.omega.map(|omega| -skew(&omega));
    let Rt = at.R.transpose();
    let Rt_dot = spin * Rt;
    let Rt_ddot = spin_dot * Rt + spin * Rt_dot;
    [
        A[0] * Rt,
        A[1] * Rt + A[0] * Rt_dot,
        A[2] * Rt + A[1] * Rt_dot * 2.0 + A[0] * Rt_ddot,
    ]
}

impl CoincidePoses {
    fn at(&self, [q, v, a]: [&[f64]; 3]) -> Apart {
        let between = |x: &[f64], k: usize| three_or_zero(x, k) - three_or_zero(x, 6 + k);
        let [of_a, of_b] = [&q[..6], &q[6..]].map(orientation);
        let R = of_b.rotation();
        let [Omega, Omega_dot] = [v, a].map(|x| R.tr_mul(&three_or_zero(x, 9)));
        let g = R.tr_mul(&(between(q, 0) + self.0.apart));
        let shift = R.tr_mul(&between(v, 0));
        let g_dot = shift + g.cross(&Omega);
        let shift_dot = R.tr_mul(&between(a, 0)) - Omega.cross(&shift);
        let g_ddot = shift_dot + g_dot.cross(&Omega) + g.cross(&Omega_dot);
        let p = of_b.conjugate().product(&of_a);
        let p = if p.w < 0.0 { p.opposite() } else { p };
        let W = R.tr_mul(&between(v, 3));
        let W_dot = R.tr_mul(&between(a, 3)) - Omega.cross(&W);
        let v_dot = (W * p.w + W.cross(&p.v)) * 0.5;
        let w_dot = -0.5 * W.dot(&p.v);
        let v_ddot = (W * w_dot + W.cross(&v_dot) + W_dot * p.w + W_dot.cross(&p.v)) * 0.5;
        Apart {
            R,
            g: [g, g_dot, g_ddot],
            w: [p.w, w_dot, -0.5 * (W_dot.dot(&p.v) + W.dot(&v_dot))],
            v: [p.v, v_dot, v_ddot],
            omega: [Omega, Omega_dot],
        }
    }
}

impl Parametrization for CoincidePoses {
    fn dims(&self) -> (usize, usize) {
        (12, 6)
    }

    fn evaluate(&mut self, _t: f64, motion: [&[f64]; 3], out: &mut [Order<'_>]) {
        let at = self.at(motion);
        let still = [Matrix3::identity(), Matrix3::zeros(), Matrix3::zeros()];
        let shifts = turned(still, &at);
        let levers = turned(at.g.map(|g| skew(&g)), &at);
        let L = [0, 1, 2].map(|k| Matrix3::from_diagonal_element(at.w[k]) - skew(&at.v[k]));
        let turns = turned(L, &at);
        for (k, [x, B]) in out.iter_mut().enumerate() {
            x[..3].copy_from_slice(at.g[k].as_slice());
            x[3..].copy_from_slice((at.v[k] * 2.0).as_slice());
            B.fill(0.0);
            write_block(B, 6, [0, 0], &shifts[k]);
            write_block(B, 6, [0, 6], &-shifts[k]);
            write_block(B, 6, [0, 9], &levers[k]);
            write_block(B, 6, [3, 3], &turns[k]);
            write_block(B, 6, [3, 9], &-turns[k]);
        }
    }

    fn geometric_stiffness(&mut self, _t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        let at = self.at([q, &[], &[]]);
        let (w, v) = (at.w[0], at.v[0]);
        let [f, mu] = [0, 3].map(|k| three(f, k));
        let force = skew(&(at.R * f));
        let arm = skew(&(at.R * at.g[0]));
        let moment = skew(&(at.R * (mu * w + v.cross(&mu))));
        let L = Matrix3::from_diagonal_element(w) - skew(&v);
        let N = (mu * v.transpose() + skew(&mu) * L) * -0.5;
        let N = at.R * N * at.R.transpose();
        K.fill(0.0);
        write_block(K, 12, [0, 9], &-force);
        write_block(K, 12, [6, 9], &force);
        write_block(K, 12, [9, 0], &force);
        write_block(K, 12, [9, 6], &-force);
        write_block(K, 12, [3, 3], &N);
        write_block(K, 12, [3, 9], &(-moment - N));
        write_block(K, 12, [9, 3], &-N);
        write_block(K, 12, [9, 9], &(arm * force + moment + N));
    }
}
