//! Rotations by increments: the chart of the updated Lagrangian formulation.

#![allow(non_snake_case)]

use super::{Map, Rewritten};
use crate::quotients::Quotients;
use crate::scalar::Scalar;
use crate::so3::{self, Quaternion};
use crate::system::ChartChanges;
use nalgebra::{SVector, Vector3};
use std::f64::consts::{PI, TAU};

/// A frame whose coordinates are its displacement and the material rotation vector θ since the last
/// converged step, (d, θ) ↦ (d, Ψ) with R(Ψ) = Rₙ R(θ).
///
/// After every step θ begins anew at zero, where θ̇ = Ω and θ̈ = Ω̇: the updated Lagrangian
/// formulation of Cardona & Géradin 1988 (\[M04\] 3.3) for any scheme and any element, as a chart
/// that is centred anew. With the angular velocities of θ,
///
/// ```text
/// Ω = T(θ) θ̇,   Ω̇ = T(θ) θ̈ + Ṫ θ̇                                       [M04] (50)
/// ```
///
/// the new velocities and accelerations are exact. Only this map may use the coordinates θ
/// ([`Map::rewrites`]): a node of six coordinates, three lengths and three angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Increment {
    /// Rₙ, as the quaternion of the sheet of Ψ in use.
    turn: Quaternion<f64>,
}

impl Default for Increment {
    /// From the reference orientation.
    fn default() -> Self {
        Self {
            turn: so3::quaternion(&Vector3::zeros()),
        }
    }
}

impl Increment {
    /// From an orientation, by its rotation vector (global components, ψ < 2π).
    pub fn from(Psi: &Vector3<f64>) -> Self {
        Self {
            turn: so3::quaternion(Psi),
        }
    }

    /// The quaternion of Rₙ R(θ).
    fn turned<S: Scalar>(&self, q: &SVector<S, 6>) -> Quaternion<S> {
        let Quaternion { w, v } = self.turn;
        let turn = Quaternion {
            w: S::constant(w),
            v: v.map(S::constant),
        };
        turn.product(&so3::quaternion(&theta(q)))
    }
}

fn theta<S: Scalar>(q: &SVector<S, 6>) -> Vector3<S> {
    Vector3::new(q[3], q[4], q[5])
}

impl Map<6, 6> for Increment {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 6>) -> SVector<S, 6> {
        let Psi = so3::log_quaternion(&self.turned(q));
        SVector::from([q[0], q[1], q[2], Psi.x, Psi.y, Psi.z])
    }

    /// θ stays below half a turn, and Ψ inside its chart.
    fn margin(&self, _t: f64, q: &SVector<f64, 6>) -> f64 {
        let Psi = so3::log_quaternion(&self.turned(q)).norm();
        (PI - theta(q).norm()).min(TAU - Psi)
    }

    /// Its coordinates are no frame's.
    fn is_objective(&self) -> bool {
        false
    }

    /// The sheet on which ψ ≤ π.
    fn change_charts(&mut self, _t: f64, q: &SVector<f64, 6>) -> ChartChanges {
        let beyond = self.turned(q).w < 0.0;
        if beyond {
            self.turn = self.turn.opposite();
        }
        ChartChanges {
            charts: usize::from(beyond),
            residual: false,
        }
    }

    fn rewrites(&self) -> bool {
        true
    }

    fn rewrite(
        &mut self,
        _t: f64,
        q: &SVector<f64, 6>,
        v: &SVector<f64, 6>,
    ) -> Option<Rewritten<6>> {
        let (theta, theta_dot) = (theta(q), self::theta(v));
        if theta == Vector3::zeros() {
            return None;
        }
        let turned = self.turned(q);
        let scale = 1.0 / (turned.w * turned.w + turned.v.norm_squared()).sqrt();
        self.turn = Quaternion {
            w: turned.w * scale,
            v: turned.v * scale,
        };
        let T = so3::tangent(&theta);
        let mut new = Rewritten {
            q: *q,
            v: *v,
            B: nalgebra::SMatrix::identity(),
            c: SVector::zeros(),
        };
        new.q.fixed_rows_mut::<3>(3).fill(0.0);
        new.v.fixed_rows_mut::<3>(3).copy_from(&(T * theta_dot));
        new.B.fixed_view_mut::<3, 3>(3, 3).copy_from(&T);
        let c = so3::T_dot_psi_dot(&theta_dot, &theta, &Quotients::new(theta.norm()));
        new.c.fixed_rows_mut::<3>(3).copy_from(&c);
        Some(new)
    }
}
