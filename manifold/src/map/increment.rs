//! Rotations by increments: the chart of the updated Lagrangian formulation.

use super::{Map, MapState, Reparametrization};
use crate::domain::{CHART_EDGE, DomainError};
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
/// ([`Reparametrization`]): six coordinates of a frame, three lengths and three angles, or three
/// of a rotation alone, θ ↦ Ψ. D is 6 or 3 accordingly.
///
/// With [`Increment::with_velocities`], the rates are angular velocities from the first converged
/// state on ([`Reparametrization::velocity_kind`]). With material ones, Ω and Ω̇ instead of θ̇ and θ̈, the updates
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
pub struct Increment<const D: usize> {
    /// Rₙ, as the quaternion of the branch of Ψ in use.
    turn: Quaternion<f64>,
    /// Angular velocities that replace the rates once the chart is centred, and whether it has been.
    velocity_kind: Option<VelocityKind>,
    centred: bool,
}

impl<const D: usize> Default for Increment<D> {
    /// From the reference orientation.
    fn default() -> Self {
        Self::from(&Vector3::zeros())
    }
}

impl<const D: usize> Increment<D> {
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
    fn turned<S: Scalar>(&self, q: &SVector<S, D>) -> Quaternion<S> {
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

impl<const D: usize> Map<D, D> for Increment<D> {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, D>) -> SVector<S, D> {
        let Psi = so3::log_quaternion(&self.turned(q));
        let mut x = *q;
        x.fixed_rows_mut::<3>(D - 3).copy_from(&Psi);
        x
    }

    /// θ stays below half a turn, and Ψ inside its chart.
    fn domain(&self, _t: f64, q: &SVector<f64, D>) -> Result<f64, DomainError> {
        let Psi = so3::log_quaternion(&self.turned(q)).norm();
        DomainError::within((PI - theta(q).norm()).min(TAU - Psi), CHART_EDGE)
    }

    fn state(&mut self) -> Option<&mut dyn MapState> {
        Some(self)
    }
}

impl<const D: usize> MapState for Increment<D> {
    /// The branch on which ψ ≤ π.
    fn change_charts(&mut self, _t: f64, q: &[f64]) -> ChartChanges {
        let beyond = self.turned(&SVector::from_column_slice(q)).w < 0.0;
        if beyond {
            self.turn = self.turn.opposite();
        }
        ChartChanges::of(usize::from(beyond))
    }

    /// Rₙ as a quaternion (w, v), and whether the chart has been centred.
    fn save(&self) -> Vec<f64> {
        let Quaternion { w, v } = self.turn;
        vec![w, v.x, v.y, v.z, f64::from(self.centred)]
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

    fn reparametrization(&mut self) -> Option<&mut dyn Reparametrization> {
        Some(self)
    }
}

impl<const D: usize> Reparametrization for Increment<D> {
    fn reparametrize(&mut self, _t: f64, q: &mut [f64], v: &mut [f64], a: &mut [Vec<f64>]) -> bool {
        let three = |x: &[f64]| Vector3::new(x[D - 3], x[D - 2], x[D - 1]);
        let (theta, theta_dot) = (three(q), three(v));
        let kind = self.velocity_kind();
        self.centred = true;
        if theta == Vector3::zeros() {
            return false;
        }
        let turned = self.turned(&SVector::from_column_slice(q));
        let scale = 1.0 / (turned.w * turned.w + turned.v.norm_squared()).sqrt();
        self.turn = Quaternion {
            w: turned.w * scale,
            v: turned.v * scale,
        };
        q[D - 3..].fill(0.0);
        // From rates or angular velocities at θ to Ω and Ω̇.
        let B = match kind {
            Some(VelocityKind::Material) => return true,
            Some(VelocityKind::Spatial | VelocityKind::Mixed) => so3::rotation(&theta).transpose(),
            None => so3::tangent(&theta),
        };
        v[D - 3..].copy_from_slice((B * theta_dot).as_slice());
        if kind == Some(VelocityKind::Mixed) {
            return true;
        }
        let c = match kind {
            None => so3::T_dot_psi_dot(&theta_dot, &theta, &Quotients::new(theta.norm())),
            Some(_) => Vector3::zeros(),
        };
        for a in a {
            let accelerations = B * three(a) + c;
            a[D - 3..].copy_from_slice(accelerations.as_slice());
        }
        true
    }

    fn velocity_kind(&self) -> Option<VelocityKind> {
        self.velocity_kind.filter(|_| self.centred)
    }
}
