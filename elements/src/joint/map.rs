//! The maps of joints: from a parent frame and the coordinates of a joint to the child frame.

#![allow(non_snake_case)]

use super::link::{Link, Rates, orders, own, put, unit, vector};
use super::{Joint, LogBranch, Slide};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use pullback_manifold::map::{
    KinematicsMut, Map, Parametrization, write_geometric_stiffness, write_kinematics, write_tangent,
};
use pullback_manifold::quotients::{InverseQuotients, Quotients};
use pullback_manifold::so3;
use pullback_manifold::system::ChartChanges;
use std::f64::consts::TAU;

/// A joint as a map (d, Ψ of the parent, q) ↦ (d, Ψ of the child).
///
/// The rotation vector of the child stays on one branch during a step and changes at a converged state
/// with ψ > π. Outside of its domain is also a joint whose pose has no unit quaternion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointMap<J, const D: usize> {
    link: Link<J, D>,
    branch: LogBranch,
}

/// A joint whose child turns freely: the map (d, Ψ of the parent, q, Ψ of the child) ↦ (d, Ψ of the child).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeJointMap<J, const D: usize>(Link<J, D>);

impl<J: Joint<D>, const D: usize> JointMap<J, D> {
    /// The map of a joint.
    pub fn new(joint: J) -> Self {
        Self {
            link: Link::new(joint),
            branch: LogBranch::default(),
        }
    }

    /// \[M04\] (207) and its two time derivatives, solved for the rotation vector of the child; as many
    /// orders as there is room for.
    fn write(&self, t: f64, motion: [&[f64]; 3], out: &mut [[&mut [f64]; 2]]) {
        let at = self.link.carried(t, motion);
        self.link.write_position(&at, motion, out);
        let psi = self.branch.log(&at.rotation);
        let inverse = so3::T_inverse(&psi, &InverseQuotients::new(psi.norm())).transpose();
        let psi_dot = inverse * at.omega[0];
        let c = Quotients::new(psi.norm());
        let tangent_dot = so3::T_dot(&psi_dot, &psi, &c).transpose();
        let psi_ddot = inverse * (at.omega[1] - tangent_dot * psi_dot);
        let tangent_ddot = so3::T_ddot(&psi_dot, &psi_ddot, &psi, &c).transpose();
        let rates = [tangent_dot, tangent_ddot];
        let parents = solve(&inverse, &rates, &at.parent.tangent);
        let own = solve(&inverse, &rates, &at.beta);
        let psi = [psi, psi_dot, psi_ddot];
        for (k, [x, B]) in out.iter_mut().enumerate() {
            x[3..].copy_from_slice(psi[k].as_slice());
            put(B, 6, [3, 0], &Matrix3::zeros());
            put(B, 6, [3, 3], &parents[k]);
            put(B, 6, [3, 6], &own[k]);
        }
    }
}

impl<J: Joint<D>, const D: usize> FreeJointMap<J, D> {
    /// The map of a joint whose child turns freely.
    pub fn new(joint: J) -> Self {
        Self(Link::new(joint))
    }

    fn write(&self, t: f64, motion: [&[f64]; 3], out: &mut [[&mut [f64]; 2]]) {
        for (k, [x, B]) in out.iter_mut().enumerate() {
            x[3..].copy_from_slice(vector(motion[k], 6 + D).as_slice());
            B.fill(0.0);
            put(B, 6, [3, 6 + D], &unit(k));
        }
        self.0
            .write_position(&self.0.carried(t, motion), motion, out);
    }
}

impl<J, const D: usize> Parametrization for JointMap<J, D>
where
    J: Joint<D> + Clone + 'static,
{
    fn kind(&self) -> &'static str {
        std::any::type_name::<J>()
    }

    fn dims(&self) -> (usize, usize) {
        (6 + D, 6)
    }

    fn duplicate(&self) -> Box<dyn Parametrization> {
        Box::new(self.clone())
    }

    fn margin(&mut self, t: f64, q: &[f64]) -> f64 {
        self.link.margin(t, q, |turn| {
            let w = match self.branch {
                LogBranch::Same => turn.w,
                LogBranch::Opposite => -turn.w,
            };
            // ψ = 2 atan2(|v|, w).
            TAU - 2.0 * turn.v.norm().atan2(w)
        })
    }

    fn edge(&self) -> &'static str {
        self.link.joint.edge()
    }

    fn domain_error(&mut self, t: f64, q: &[f64]) -> Option<String> {
        self.link.domain_error(t, q)
    }

    fn freeze_piece(&mut self, at: Option<(f64, &[f64])>) {
        let at = at.map(|(t, q)| (t, own(q)));
        self.link
            .joint
            .freeze_piece(at.as_ref().map(|(t, q)| (*t, q)));
    }

    fn change_charts(&mut self, t: f64, q: &[f64]) -> ChartChanges {
        let best = if self.link.rotation(t, q).w < 0.0 {
            LogBranch::Opposite
        } else {
            LogBranch::Same
        };
        let changed = std::mem::replace(&mut self.branch, best) != best;
        ChartChanges {
            charts: usize::from(changed),
            residual: false,
        }
    }

    fn tangent(&mut self, t: f64, q: &[f64], x: &mut [f64], B: &mut [f64]) {
        self.write(t, [q, &[], &[]], &mut [[x, B]]);
    }

    fn kinematics(&mut self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: KinematicsMut<'_>) {
        self.write(t, [q, v, a], &mut orders(out));
    }

    /// \[M04\] (212) for any joint.
    fn geometric_stiffness(&mut self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        let psi = self.branch.log(&self.link.rotation(t, q));
        let covector = vector(f, 3);
        let inverse = InverseQuotients::new(psi.norm());
        let T_inverse = so3::T_inverse(&psi, &inverse);
        let m = T_inverse * covector;
        // The covector stays as the child turns: δm = D_Ψ(T⁻¹ f) T⁻ᵀ δθ.
        let N = -so3::C6(&covector, &-psi, &inverse) * T_inverse.transpose();
        K.fill(0.0);
        let to = (K, 6 + D);
        self.link
            .write_stiffness((t, q), [&vector(f, 0), &m], &N, to);
    }
}

impl<J, const D: usize> Parametrization for FreeJointMap<J, D>
where
    J: Joint<D> + Clone + 'static,
{
    fn kind(&self) -> &'static str {
        std::any::type_name::<J>()
    }

    fn dims(&self) -> (usize, usize) {
        (9 + D, 6)
    }

    fn duplicate(&self) -> Box<dyn Parametrization> {
        Box::new(self.clone())
    }

    fn margin(&mut self, t: f64, q: &[f64]) -> f64 {
        self.0.margin(t, q, |_| TAU - vector(q, 6 + D).norm())
    }

    fn edge(&self) -> &'static str {
        self.0.joint.edge()
    }

    fn domain_error(&mut self, t: f64, q: &[f64]) -> Option<String> {
        self.0.domain_error(t, q)
    }

    fn freeze_piece(&mut self, at: Option<(f64, &[f64])>) {
        let at = at.map(|(t, q)| (t, own(q)));
        self.0.joint.freeze_piece(at.as_ref().map(|(t, q)| (*t, q)));
    }

    fn tangent(&mut self, t: f64, q: &[f64], x: &mut [f64], B: &mut [f64]) {
        self.write(t, [q, &[], &[]], &mut [[x, B]]);
    }

    fn kinematics(&mut self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: KinematicsMut<'_>) {
        self.write(t, [q, v, a], &mut orders(out));
    }

    fn geometric_stiffness(&mut self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        K.fill(0.0);
        let forces = [&vector(f, 0), &Vector3::zeros()];
        self.0
            .write_stiffness((t, q), forces, &Matrix3::zeros(), (K, 9 + D));
    }
}

/// Along a chain of beam elements: its segment is part of its state.
impl Parametrization for Slide {
    fn dims(&self) -> (usize, usize) {
        (13, 6)
    }

    fn duplicate(&self) -> Box<dyn Parametrization> {
        Box::new(self.clone())
    }

    fn margin(&mut self, t: f64, q: &[f64]) -> f64 {
        Map::margin(self, t, &SVector::from_column_slice(q))
    }

    fn edge(&self) -> &'static str {
        Map::edge(self)
    }

    fn change_charts(&mut self, _t: f64, q: &[f64]) -> ChartChanges {
        let psi = [3, 9].map(|k| Vector3::new(q[k], q[k + 1], q[k + 2]));
        let on = self.chain.change_segments(q[12]);
        // Handed over, it has the nodes of another element than `q`.
        let residual = self.turn.choose((!on).then_some(psi)) || on;
        let charts = usize::from(residual);
        ChartChanges { charts, residual }
    }

    fn segment(&self) -> usize {
        self.chain.line()
    }

    fn overshoot(&self, h: f64, from: [&[f64]; 2], to: [&[f64]; 2]) -> Option<(f64, usize)> {
        let [from, to] = [from, to].map(|[q, v]| [q[12], v[12]]);
        self.chain.leaves(h, from, to)
    }

    fn enter(&mut self, segment: usize) {
        self.chain.enter(segment as f64);
    }

    fn save(&self) -> Vec<f64> {
        vec![self.chain.line() as f64]
    }

    fn restore(&mut self, saved: &[f64]) -> bool {
        matches!(*saved, [line] if self.chain.enter(line))
    }

    fn tangent(&mut self, t: f64, q: &[f64], x: &mut [f64], B: &mut [f64]) {
        write_tangent(self, t, q, x, B);
    }

    fn kinematics(&mut self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: KinematicsMut<'_>) {
        write_kinematics(self, t, [q, v, a], out);
    }

    fn geometric_stiffness(&mut self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        write_geometric_stiffness(self, t, q, f, K);
    }
}

/// X and its rates from Tᵀ X = S, with T⁻ᵀ and the rates of Tᵀ given.
fn solve<const N: usize>(
    inverse: &Matrix3<f64>,
    [rate, second]: &[Matrix3<f64>; 2],
    [S, S_dot, S_ddot]: &Rates<SMatrix<f64, 3, N>>,
) -> Rates<SMatrix<f64, 3, N>> {
    let X = inverse * S;
    let X_dot = inverse * (S_dot - rate * X);
    let X_ddot = inverse * (S_ddot - second * X - rate * X_dot * 2.0);
    [X, X_dot, X_ddot]
}
