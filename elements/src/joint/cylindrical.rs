//! The cylindrical joint: a displacement along an axis and a turn about it.

use super::{AxisError, Joint, JointCoordinate, Pose, direction};
use nalgebra::{SVector, Vector3};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::Quaternion;
use pullback_manifold::system::Quantity;

/// d_s = d_m + R_m u e, R_s = R_m R(φ e): parents (frame, displacement u, angle φ).
///
#[doc = include_str!("../../images/cylindrical.svg")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylindrical {
    axis: Vector3<f64>,
}

impl Cylindrical {
    /// The joint along an axis of any length, in global components of the reference configuration;
    /// an error for one without a direction.
    pub fn new(axis: [f64; 3]) -> Result<Self, AxisError> {
        let axis = direction(axis)?;
        Ok(Self { axis })
    }
}

impl Joint<2> for Cylindrical {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 2>) -> Pose<S> {
        Pose::from_translation(self.axis.map(S::constant) * q[0])
            .rotated(&Quaternion::about(&self.axis, q[1]))
    }

    fn coordinates(&self) -> [JointCoordinate; 2] {
        [
            ("displacement", Quantity::Length),
            ("angle", Quantity::Angle),
        ]
    }
}
