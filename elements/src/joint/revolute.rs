//! The revolute joint: two frames share a position and an axis; the angle between them is unbounded.

use super::{AxisError, Joint, JointCoordinate, Pose, direction};
use nalgebra::{SVector, Vector3};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::Quaternion;
use pullback_manifold::system::Quantity;

/// d_s = d_m, R_s = R_m R(φ e): parents (frame, angle φ); \[M04\] 4.1.4.
///
#[doc = include_str!("../../images/revolute.svg")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Revolute {
    axis: Vector3<f64>,
}

impl Revolute {
    /// The joint about an axis of any length, in global components of the reference
    /// configuration; an error for an axis without a direction.
    pub fn new(axis: [f64; 3]) -> Result<Self, AxisError> {
        let axis = direction(axis)?;
        Ok(Self { axis })
    }
}

impl Joint<1> for Revolute {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 1>) -> Pose<S> {
        Pose::from_rotation(Quaternion::about(&self.axis, q[0]))
    }

    fn coordinates(&self) -> [JointCoordinate; 1] {
        [("angle", Quantity::Angle)]
    }
}
