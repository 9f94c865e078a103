//! Charts of rotations: three coordinates, their domain, and the change between them.

mod charted;
mod wiener_milenkovic;

pub use charted::Charted;
pub use wiener_milenkovic::WienerMilenkovic;

use crate::domain::{CHART_EDGE, DomainError};
use crate::map::{Kinematics, Map, Tangent};
use crate::scalar::Scalar;
use crate::so3::{self, Quaternion};
use nalgebra::{SMatrix, Vector3};
use std::f64::consts::TAU;

/// A chart of rotations: three coordinates c of a unit quaternion.
///
/// A quaternion and its opposite are the same rotation. Their coordinates are those of two charts, and a
/// chart changes to the other one where w < 0 (ψ > π): at the end of a step, within which ψ has passed π.
/// Quaternions with w < 0 therefore have coordinates of their own. A chart that represents them by those of
/// their opposites or ends at w = 0, such as tan(ψ/2) e or 2 sin(ψ/2) e, does not suffice. [`Charted`] derives
/// all else from these two functions: rates, forces, stiffness, and the change of chart.
pub trait RotationChart: Copy + Send + Sync + 'static {
    /// The unit quaternion of coordinates, smooth, with w > −1.
    fn quaternion<S: Scalar>(&self, c: &Vector3<S>) -> Quaternion<S>;

    /// The coordinates of a unit quaternion: [`quaternion`](Self::quaternion) gives it back with its sign.
    fn coordinates<S: Scalar>(&self, rotation: &Quaternion<S>) -> Vector3<S>;

    /// Distance of c to the edge of the chart: positive inside, infinite for a chart without an edge.
    fn margin(&self, c: &Vector3<f64>) -> f64 {
        let _ = c;
        f64::INFINITY
    }
}

/// The complement rotation vector Ψᶜ = Ψ − 2π Ψ/ψ, the same rotation in the other chart
/// (\[M04\] definition 15, 4.1.1). It is its own inverse, and undefined at ψ = 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Complement;

impl Map<3, 3> for Complement {
    fn phi<S: Scalar>(&self, _t: S, q: &Vector3<S>) -> Vector3<S> {
        so3::complement(q)
    }

    fn domain(&self, _t: f64, q: &Vector3<f64>) -> Result<f64, DomainError> {
        let psi = q.norm();
        DomainError::within(psi.min(TAU - psi), CHART_EDGE)
    }

    fn tangent(&self, _t: f64, q: &Vector3<f64>) -> Tangent<3, 3> {
        Tangent {
            x: so3::complement(q),
            B: so3::B_s(q),
        }
    }

    fn kinematics(
        &self,
        _t: f64,
        q: &Vector3<f64>,
        v: &Vector3<f64>,
        a: &Vector3<f64>,
    ) -> Kinematics<3, 3> {
        let (B, B_dot) = (so3::B_s(q), so3::B_s_dot(v, q));
        Kinematics {
            x: so3::complement(q),
            x_dot: B * v,
            x_ddot: B * a + B_dot * v,
            B,
            B_dot,
            B_ddot: so3::B_s_ddot(a, v, q),
        }
    }

    fn geometric_stiffness(
        &self,
        _t: f64,
        q: &Vector3<f64>,
        f: &Vector3<f64>,
    ) -> SMatrix<f64, 3, 3> {
        so3::K_sigma_s(f, q)
    }
}
