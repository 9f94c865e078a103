//! Rotations by increments: the chart of the updated Lagrangian formulation.

#![allow(non_snake_case)]

use super::{Map, Reparametrized};
use crate::quotients::Quotients;
use crate::scalar::Scalar;
use crate::so3::{self, Quaternion, VelocityKind};
use crate::system::ChartChanges;
use nalgebra::{SVector, Vector3};
use std::f64::consts::{PI, TAU};

/// A frame whose coordinates are its displacement d and the material rotation vector θ since the
/// last converged step, (d, θ) ↦ (d, Ψ) with R(Ψ) = Rₙ R(θ).
///
/// After every step θ restarts at zero, where θ̇ = Ω and θ̈ = Ω̇: the updated Lagrangian formulation
/// of Cardona & Géradin 1988 (\[M04\] 3.3) for any scheme and any element. With the angular
/// velocities of θ,
///
/// ```text
/// Ω = T(θ) θ̇,   Ω̇ = T(θ) θ̈ + Ṫ θ̇                                       [M04] (50)
/// ```
///
/// the new velocities and accelerations are exact. Only this map may use the coordinates θ
/// ([`Map::reparametrizes`]): six coordinates of a frame, three lengths and three angles, or three
/// of a rotation alone, θ ↦ Ψ. D is 6 or 3 accordingly.
///
/// With [`Increment::with_velocities`], the rates are angular velocities from the first converged
/// state on ([`Map::velocity_kind`]). With material ones, Ω and Ω̇ instead of θ̇ and θ̈, the updates
/// of the generalised-α family are those of the Lie-group method of Brüls, Cardona & Arnold 2012,
///
/// ```text
/// Rₙ₊₁ = Rₙ R(h Ωₙ + h²[(½−β) aₙ + β aₙ₊₁]),   Ωₙ₊₁ = Ωₙ + h[(1−γ) aₙ + γ aₙ₊₁]
/// ```
///
/// where θ̇ = Ω and θ̈ = Ω̇ at θ = 0, so recentring the chart changes nothing. With spatial ones the
/// updates are sums of ω and ω̇, with R(…) on the left of Rₙ; with mixed ones, sums of w and of the
/// material Ω̇, which recentring leaves unchanged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Increment {
    /// Rₙ, as the quaternion of the branch of Ψ in use.
    turn: Quaternion<f64>,
    /// Angular velocities that replace the rates once the chart is centred, and whether it has been.
    velocity_kind: Option<VelocityKind>,
    centred: bool,
}

impl Default for Increment {
    /// From the reference orientation.
    fn default() -> Self {
        Self::from(&Vector3::zeros())
    }
}

impl Increment {
    /// From an orientation, by its rotation vector (global components, ψ < 2π).
    pub fn from(Psi: &Vector3<f64>) -> Self {
        Self {
            turn: so3::quaternion(Psi),
            velocity_kind: None,
            centred: false,
        }
    }

    /// The reference orientation, with angular velocities as rates.
    pub fn with_velocities(kind: VelocityKind) -> Self {
        Self {
            velocity_kind: Some(kind),
            ..Self::default()
        }
    }

    /// The quaternion of Rₙ R(θ).
    fn turned<S: Scalar, const D: usize>(&self, q: &SVector<S, D>) -> Quaternion<S> {
        let Quaternion { w, v } = self.turn;
        let turn = Quaternion {
            w: S::constant(w),
            v: v.map(S::constant),
        };
        turn.product(&so3::quaternion(&theta(q)))
    }
}

fn theta<S: Scalar, const D: usize>(q: &SVector<S, D>) -> Vector3<S> {
    Vector3::new(q[D - 3], q[D - 2], q[D - 1])
}

impl<const D: usize> Map<D, D> for Increment {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, D>) -> SVector<S, D> {
        let Psi = so3::log_quaternion(&self.turned(q));
        let mut x = *q;
        x.fixed_rows_mut::<3>(D - 3).copy_from(&Psi);
        x
    }

    /// θ stays below half a turn, and Ψ inside its chart.
    fn margin(&self, _t: f64, q: &SVector<f64, D>) -> f64 {
        let Psi = so3::log_quaternion(&self.turned(q)).norm();
        (PI - theta(q).norm()).min(TAU - Psi)
    }

    /// Its coordinates belong to no frame.
    fn is_objective(&self) -> bool {
        false
    }

    /// The branch on which ψ ≤ π.
    fn change_charts(&mut self, _t: f64, q: &SVector<f64, D>) -> ChartChanges {
        let beyond = self.turned(q).w < 0.0;
        if beyond {
            self.turn = self.turn.opposite();
        }
        ChartChanges {
            charts: usize::from(beyond),
            residual: false,
        }
    }

    fn reparametrizes(&self) -> bool {
        true
    }

    fn velocity_kind(&self) -> Option<VelocityKind> {
        self.velocity_kind.filter(|_| self.centred)
    }

    /// Rₙ as a quaternion (w, v), and whether the chart has been centred.
    fn save(&self) -> Vec<f64> {
        let Quaternion { w, v } = self.turn;
        vec![w, v.x, v.y, v.z, f64::from(u8::from(self.centred))]
    }

    fn restore(&mut self, saved: &[f64]) -> bool {
        let &[w, x, y, z, centred] = saved else {
            return false;
        };
        let v = Vector3::new(x, y, z);
        let unit = (w * w + v.norm_squared() - 1.0).abs() < 1e-9;
        if unit {
            self.turn = Quaternion { w, v };
            self.centred = centred != 0.0;
        }
        unit
    }

    fn reparametrize(
        &mut self,
        _t: f64,
        q: &SVector<f64, D>,
        v: &SVector<f64, D>,
    ) -> Option<Reparametrized<D>> {
        let (theta, theta_dot) = (theta(q), self::theta(v));
        let kind = Map::<D, D>::velocity_kind(self);
        self.centred = true;
        if theta == Vector3::zeros() {
            return None;
        }
        let turned = self.turned(q);
        let scale = 1.0 / (turned.w * turned.w + turned.v.norm_squared()).sqrt();
        self.turn = Quaternion {
            w: turned.w * scale,
            v: turned.v * scale,
        };
        let mut new = Reparametrized {
            q: *q,
            v: *v,
            B: nalgebra::SMatrix::identity(),
            c: SVector::zeros(),
        };
        new.q.fixed_rows_mut::<3>(D - 3).fill(0.0);
        // From rates or angular velocities at θ to Ω and Ω̇.
        let B = match kind {
            Some(VelocityKind::Material) => return Some(new),
            Some(VelocityKind::Spatial | VelocityKind::Mixed) => so3::rotation(&theta).transpose(),
            None => so3::tangent(&theta),
        };
        new.v.fixed_rows_mut::<3>(D - 3).copy_from(&(B * theta_dot));
        if kind != Some(VelocityKind::Mixed) {
            new.B.fixed_view_mut::<3, 3>(D - 3, D - 3).copy_from(&B);
        }
        if kind.is_none() {
            let c = so3::T_dot_psi_dot(&theta_dot, &theta, &Quotients::new(theta.norm()));
            new.c.fixed_rows_mut::<3>(D - 3).copy_from(&c);
        }
        Some(new)
    }
}
