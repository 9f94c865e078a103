//! The universal (Hooke's, Cardan) joint: two turns about crossed axes.

use super::{AxisError, Joint, JointCoordinate, PARALLEL, Pose, direction};
use nalgebra::{SVector, Vector3};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::Quaternion;
use pullback_manifold::system::Quantity;

/// R_s = R_m R(α e₁) R(β e₂): parents (frame, angle 1, angle 2).
///
/// The first axis is fixed in the parent, the second in the child. Nothing is singular in this
/// description; at β = ±90° with axes at right angles a shaft across both would be locked, which a
/// loop of such shafts shows as a singular tangent.
///
#[doc = include_str!("../../images/universal.svg")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Universal {
    axes: [Vector3<f64>; 2],
}

impl Universal {
    /// The joint with two axes of any length, in global components of the reference configuration;
    /// an error for axes without a direction, or parallel ones.
    pub fn new(axes: [[f64; 3]; 2]) -> Result<Self, AxisError> {
        let axes = [direction(axes[0])?, direction(axes[1])?];
        if axes[0].cross(&axes[1]).norm() <= PARALLEL {
            return Err(AxisError::Parallel);
        }
        Ok(Self { axes })
    }
}

impl Joint<2> for Universal {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 2>) -> Pose<S> {
        Pose::from_rotation(Quaternion::about(&self.axes[0], q[0]))
            .rotated(&Quaternion::about(&self.axes[1], q[1]))
    }

    fn coordinates(&self) -> [JointCoordinate; 2] {
        [("angle 1", Quantity::Angle), ("angle 2", Quantity::Angle)]
    }
}
