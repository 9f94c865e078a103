//! The planar joint: two displacements in a plane and the turn about its normal.

use super::{AxisError, Joint, JointCoordinate, PARALLEL, Pose, direction};
use nalgebra::{SVector, Vector3};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::Quaternion;
use pullback_manifold::system::Quantity;

/// d_s = d_m + R_m (u a + v b), R_s = R_m R(φ n): parents (frame, displacements u, v, angle φ).
///
#[doc = include_str!("../../images/planar.svg")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planar {
    across: [Vector3<f64>; 2],
    normal: Vector3<f64>,
}

impl Planar {
    /// The joint in the plane with this normal; its first displacement is along the projection of `first`
    /// on the plane. An error for axes without a direction, or parallel ones.
    pub fn new(normal: [f64; 3], first: [f64; 3]) -> Result<Self, AxisError> {
        let (normal, first) = (direction(normal)?, direction(first)?);
        let second = normal.cross(&first);
        if second.norm() <= PARALLEL {
            return Err(AxisError::Parallel);
        }
        let second = second.normalize();
        let across = [second.cross(&normal), second];
        Ok(Self { across, normal })
    }
}

impl Joint<3> for Planar {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 3>) -> Pose<S> {
        let [a, b] = self.across.map(|e| e.map(S::constant));
        Pose::from_translation(a * q[0] + b * q[1]).rotated(&Quaternion::about(&self.normal, q[2]))
    }

    fn coordinates(&self) -> [JointCoordinate; 3] {
        [
            ("displacement 1", Quantity::Length),
            ("displacement 2", Quantity::Length),
            ("angle", Quantity::Angle),
        ]
    }
}
