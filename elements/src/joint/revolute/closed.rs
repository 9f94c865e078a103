//! Closed forms of the revolute joint's derivatives: what differentiation of its map gives as well,
//! faster.

#![allow(non_snake_case)]

use super::{Joint, LogBranch, Revolute};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3, Vector6};
use pullback_manifold::jet::Taylor;
use pullback_manifold::map::Kinematics;
use pullback_manifold::quotients::{InverseQuotients, Quotients};
use pullback_manifold::so3;

/// T, Ṫ and T̈ along a motion.
fn tangents(psi: &Vector3<f64>, v: &Vector3<f64>, a: &Vector3<f64>) -> [Matrix3<f64>; 3] {
    let jet = |i: usize| Taylor {
        v: psi[i],
        d: v[i],
        dd: a[i],
    };
    let T = so3::tangent(&Vector3::new(jet(0), jet(1), jet(2)));
    [T.map(|x| x.v), T.map(|x| x.d), T.map(|x| x.dd)]
}

/// T⁻¹ applied to a 3×4 matrix.
fn solve(T_inverse: &Matrix3<f64>, b: SMatrix<f64, 3, 4>) -> SMatrix<f64, 3, 4> {
    T_inverse * b
}

/// T_s B = [R_jᵀT_m, e] (\[M04\] (207)) and its two time derivatives, solved for B, Ḃ and B̈.
pub(super) fn kinematics(
    joint: &Revolute,
    branch: LogBranch,
    q: &SVector<f64, 7>,
    v: &SVector<f64, 7>,
    a: &SVector<f64, 7>,
) -> Kinematics<7, 6> {
    let three = |x: &SVector<f64, 7>, k: usize| Vector3::new(x[k], x[k + 1], x[k + 2]);
    let four = |x: &SVector<f64, 7>| SVector::<f64, 4>::new(x[3], x[4], x[5], x[6]);
    let (psi_m, e) = (three(q, 3), &joint.axis);
    let psi = branch.log(&joint.pose(0.0, q).rotation);
    let [T, T_dot, T_ddot] = tangents(&psi_m, &three(v, 3), &three(a, 3));
    // R_jᵀ turns with −φ̇ about e: P = R_jᵀ, Ṗ = −φ̇ e~ P.
    let P = so3::rotation(&(e * -q[6]));
    let spin = so3::skew(&(e * -v[6]));
    let P_dot = spin * P;
    let P_ddot = spin * P_dot + so3::skew(&(e * -a[6])) * P;
    let side = |left: Matrix3<f64>, last: Vector3<f64>| {
        let mut out = SMatrix::<f64, 3, 4>::zeros();
        out.fixed_view_mut::<3, 3>(0, 0).copy_from(&left);
        out.set_column(3, &last);
        out
    };
    let inverse = so3::T_inverse(&psi, &InverseQuotients::new(psi.norm()));
    let B = solve(&inverse, side(P * T, *e));
    let psi_dot = B * four(v);
    // T_s along its own motion, of which the acceleration is found with Ḃ.
    let [_, Ts_dot, _] = tangents(&psi, &psi_dot, &Vector3::zeros());
    let B_dot = solve(
        &inverse,
        side(P_dot * T + P * T_dot, Vector3::zeros()) - Ts_dot * B,
    );
    let psi_ddot = B * four(a) + B_dot * four(v);
    let [_, _, Ts_ddot] = tangents(&psi, &psi_dot, &psi_ddot);
    let second = P_ddot * T + P_dot * T_dot * 2.0 + P * T_ddot;
    let B_ddot = solve(
        &inverse,
        side(second, Vector3::zeros()) - Ts_ddot * B - Ts_dot * B_dot * 2.0,
    );
    let join = |x: Vector3<f64>, y: Vector3<f64>| Vector6::new(x.x, x.y, x.z, y.x, y.y, y.z);
    let embed = |unit: f64, B: &SMatrix<f64, 3, 4>| {
        let mut out = SMatrix::<f64, 6, 7>::zeros();
        for k in 0..3 {
            out[(k, k)] = unit;
        }
        out.fixed_view_mut::<3, 4>(3, 3).copy_from(B);
        out
    };
    Kinematics {
        x: join(three(q, 0), psi),
        x_dot: join(three(v, 0), psi_dot),
        x_ddot: join(three(a, 0), psi_ddot),
        B: embed(1.0, &B),
        B_dot: embed(0.0, &B_dot),
        B_ddot: embed(0.0, &B_ddot),
    }
}

/// \[M04\] (212).
pub(super) fn geometric_stiffness(
    joint: &Revolute,
    branch: LogBranch,
    q: &SVector<f64, 7>,
    f: &Vector6<f64>,
) -> SMatrix<f64, 7, 7> {
    let (psi_m, e) = (Vector3::new(q[3], q[4], q[5]), &joint.axis);
    let f = Vector3::new(f[3], f[4], f[5]);
    let psi = branch.log(&joint.pose(0.0, q).rotation);
    let inverse = InverseQuotients::new(psi.norm());
    let T_inverse = so3::T_inverse(&psi, &inverse);
    let y = T_inverse.tr_mul(&f);
    let quotients = Quotients::new(psi_m.norm());
    let T = so3::T(&psi_m, &quotients.tangent());
    let P = so3::rotation(&(e * -q[6]));
    let D = so3::C6(&f, &psi, &inverse) * T_inverse;
    let PT = P * T;
    let K_mm = so3::C2(&P.tr_mul(&y), &psi_m, &quotients) + PT.tr_mul(&(D * PT));
    let k_m = PT.tr_mul(&(D * e + e.cross(&y)));
    let mut K = SMatrix::<f64, 7, 7>::zeros();
    K.fixed_view_mut::<3, 3>(3, 3).copy_from(&K_mm);
    K.fixed_view_mut::<3, 1>(3, 6).copy_from(&k_m);
    K.fixed_view_mut::<1, 3>(6, 3).copy_from(&k_m.transpose());
    K[(6, 6)] = e.dot(&(D * e));
    K
}
