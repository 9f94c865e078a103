//! The pose of a frame, and its coordinates in the chart of rotation vectors.
//!
//! A frame has two descriptions. In the chart its six coordinates are (d, Ψ), its rates their time
//! derivatives. As a pose they are the displacement d and the orientation, by the modified Rodrigues
//! parameters σ = tan(ψ/4) e, its rates are the velocity and the spatial angular velocity (ẋ, ω), their
//! rates (ẍ, ω̇), and its variations (δx, δθ) with δR = δθ~ R. A force at a pose is a force and a moment
//! (f, m), of the work f·δx + m·δθ.
//!
//! ```text
//! δθ = Tᵀ δΨ,   ω = Tᵀ Ψ̇,   ω̇ = Tᵀ Ψ̈ + Ṫᵀ Ψ̇,   f_Ψ = T m
//! ```
//!
//! T(Ψ), its rates and its part of K_σ stand in these two maps; a chain of joints composes poses without
//! it. Along a motion δω = δθ˙ − ω × δθ, so that tangents in the variations and their rates are pulled back
//! like those in coordinates, \[M04\] (180), (183). They are not symmetric where there is a moment; those in
//! coordinates are.

use super::{MapState, Order, Parametrization, write_block};
use crate::domain::{CHART_EDGE, DomainError, LARGEST_ANGLE};
use crate::quotients::{InverseQuotients, Quotients};
use crate::so3::{self, Quaternion};
use crate::system::ChartChanges;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// Number of coordinates of a frame.
const FRAME: usize = 6;

/// From the chart of a frame to its pose, (d, Ψ) ↦ (d, σ).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToPose;

/// From the pose of a frame to its chart, (d, σ) ↦ (d, Ψ).
///
/// The rotation vector stays on one branch during a step, and changes at a converged state with ψ > π.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ToChart {
    /// Whether the rotation vector is that of the opposite quaternion.
    opposite: bool,
}

/// The orientation of a pose, from its six coordinates.
#[inline]
#[must_use]
pub fn orientation(pose: &[f64]) -> Quaternion<f64> {
    Quaternion::from_rodrigues(&three(pose, 3))
}

fn three(x: &[f64], first: usize) -> Vector3<f64> {
    x.get(first..first + 3)
        .map_or_else(Vector3::zeros, Vector3::from_column_slice)
}

/// A position and its operator, which is the identity: as many orders as there is room for.
fn write(motion: [&[f64]; 3], turn: &[(Vector3<f64>, Matrix3<f64>)], out: &mut [Order<'_>]) {
    for (k, ([x, B], (rotation, own))) in out.iter_mut().zip(turn).enumerate() {
        x[..3].copy_from_slice(three(motion[k], 0).as_slice());
        x[3..].copy_from_slice(rotation.as_slice());
        B.fill(0.0);
        if k == 0 {
            write_block(B, FRAME, [0, 0], &Matrix3::identity());
        }
        write_block(B, FRAME, [3, 3], own);
    }
}

impl Parametrization for ToPose {
    fn dims(&self) -> (usize, usize) {
        (FRAME, FRAME)
    }

    fn domain(&mut self, _t: f64, q: &[f64]) -> Result<f64, DomainError> {
        DomainError::within(LARGEST_ANGLE - three(q, 3).norm(), CHART_EDGE)
    }

    fn evaluate(&mut self, _t: f64, [q, v, a]: [&[f64]; 3], out: &mut [Order<'_>]) {
        let [psi, psi_dot, psi_ddot] = [q, v, a].map(|x| three(x, 3));
        let c = Quotients::new(psi.norm());
        let tangent = so3::T(&psi, &c.tangent()).transpose();
        let tangent_dot = so3::T_dot(&psi_dot, &psi, &c).transpose();
        let tangent_ddot = so3::T_ddot(&psi_dot, &psi_ddot, &psi, &c).transpose();
        let turn = [
            (so3::quaternion(&psi).rodrigues(), tangent),
            (tangent * psi_dot, tangent_dot),
            (tangent * psi_ddot + tangent_dot * psi_dot, tangent_ddot),
        ];
        write([q, v, a], &turn, out);
    }

    fn geometric_stiffness(&mut self, _t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        let psi = three(q, 3);
        K.fill(0.0);
        let moment = so3::C1(&three(f, 3), &psi, &Quotients::new(psi.norm()));
        write_block(K, FRAME, [3, 3], &moment);
    }
}

impl ToChart {
    /// The quaternion on the branch in use.
    fn turn(&self, q: &[f64]) -> Quaternion<f64> {
        let turn = orientation(q);
        match self.opposite {
            true => turn.opposite(),
            false => turn,
        }
    }
}

impl Parametrization for ToChart {
    fn dims(&self) -> (usize, usize) {
        (FRAME, FRAME)
    }

    fn domain(&mut self, _t: f64, q: &[f64]) -> Result<f64, DomainError> {
        let margin = TAU - so3::log_quaternion(&self.turn(q)).norm();
        DomainError::within(margin, CHART_EDGE)
    }

    fn evaluate(&mut self, _t: f64, [q, v, a]: [&[f64]; 3], out: &mut [Order<'_>]) {
        let psi = so3::log_quaternion(&self.turn(q));
        let [omega, omega_dot] = [v, a].map(|x| three(x, 3));
        let inverse = so3::T_inverse(&psi, &InverseQuotients::new(psi.norm())).transpose();
        let psi_dot = inverse * omega;
        let c = Quotients::new(psi.norm());
        let tangent_dot = so3::T_dot(&psi_dot, &psi, &c).transpose();
        let psi_ddot = inverse * (omega_dot - tangent_dot * psi_dot);
        let tangent_ddot = so3::T_ddot(&psi_dot, &psi_ddot, &psi, &c).transpose();
        // X and its rates from Tᵀ X = 1.
        let inverse_dot = -inverse * tangent_dot * inverse;
        let inverse_ddot = -inverse * (tangent_ddot * inverse + tangent_dot * inverse_dot * 2.0);
        let turn = [
            (psi, inverse),
            (psi_dot, inverse_dot),
            (psi_ddot, inverse_ddot),
        ];
        write([q, v, a], &turn, out);
    }

    fn geometric_stiffness(&mut self, _t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        let psi = so3::log_quaternion(&self.turn(q));
        let inverse = InverseQuotients::new(psi.norm());
        let T_inverse = so3::T_inverse(&psi, &inverse);
        // The covector stays as the frame turns: δ(T⁻¹ f) = D_Ψ(T⁻¹ f) T⁻ᵀ δθ.
        let moment = -so3::C6(&three(f, 3), &-psi, &inverse) * T_inverse.transpose();
        K.fill(0.0);
        write_block(K, FRAME, [3, 3], &moment);
    }

    fn state(&mut self) -> Option<&mut dyn MapState> {
        Some(self)
    }
}

impl MapState for ToChart {
    fn change_charts(&mut self, _t: f64, q: &[f64]) -> ChartChanges {
        let changed = self.turn(q).w < 0.0;
        self.opposite ^= changed;
        ChartChanges::of(usize::from(changed))
    }

    fn save(&self) -> Vec<f64> {
        vec![f64::from(self.opposite)]
    }

    fn restore(&mut self, saved: &[f64]) -> bool {
        let &[opposite] = saved else {
            return false;
        };
        self.opposite = opposite != 0.0;
        true
    }
}
