//! The prismatic joint: a displacement along an axis, no turn.

use super::{AxisError, Joint, JointCoordinate, Pose, direction};
use nalgebra::{SVector, Vector3};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::system::Quantity;

/// d_s = d_m + R_m u e, R_s = R_m: parents (frame, displacement u).
///
#[doc = include_str!("../../images/prismatic.svg")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prismatic {
    axis: Vector3<f64>,
}

impl Prismatic {
    /// The joint along an axis of any length, in global components of the reference configuration;
    /// an error for one without a direction.
    pub fn new(axis: [f64; 3]) -> Result<Self, AxisError> {
        let axis = direction(axis)?;
        Ok(Self { axis })
    }
}

impl Joint<1> for Prismatic {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 1>) -> Pose<S> {
        Pose::from_translation(self.axis.map(S::constant) * q[0])
    }

    fn coordinates(&self) -> [JointCoordinate; 1] {
        [("displacement", Quantity::Length)]
    }
}
