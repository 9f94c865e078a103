//! The chart of Wiener and Milenković.

use super::RotationChart;
use crate::scalar::Scalar;
use crate::so3::Quaternion;
use nalgebra::Vector3;

/// Rotations by the conformal rotation vector c = 4 tan(ψ/4) e of Wiener and Milenković, rational in the
/// unit quaternion: w = (16 − c²)/(16 + c²), v = 8 c/(16 + c²) (Bauchau 2011, *Flexible Multibody
/// Dynamics*, ch. 13).
///
/// c is close to Ψ for small rotations, 4 long at ψ = π, and infinite at 2π.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WienerMilenkovic;

impl RotationChart for WienerMilenkovic {
    fn quaternion<S: Scalar>(&self, c: &Vector3<S>) -> Quaternion<S> {
        Quaternion::from_rodrigues(&(c * S::constant(0.25)))
    }

    fn coordinates<S: Scalar>(&self, rotation: &Quaternion<S>) -> Vector3<S> {
        rotation.rodrigues() * S::constant(4.0)
    }
}
