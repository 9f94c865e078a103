//! The helical joint: a screw, whose turn moves it along its axis.

use super::{AxisError, Joint, JointCoordinate, Pose, direction};
use nalgebra::{SVector, Vector3};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::Quaternion;
use pullback_manifold::system::Quantity;
use std::f64::consts::TAU;

/// d_s = d_m + R_m (p φ/2π) e, R_s = R_m R(φ e): parents (frame, angle φ).
///
#[doc = include_str!("../../images/helical.svg")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Helical {
    axis: Vector3<f64>,
    pitch: f64,
}

impl Helical {
    /// The joint along an axis of any length, in global components of the reference configuration;
    /// an error for one without a direction.
    pub fn new(axis: [f64; 3], pitch: f64) -> Result<Self, AxisError> {
        let axis = direction(axis)?;
        Ok(Self { axis, pitch })
    }
}

impl Joint<1> for Helical {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 1>) -> Pose<S> {
        let displacement = q[0] * (self.pitch / TAU);
        Pose::from_translation(self.axis.map(S::constant) * displacement)
            .rotated(&Quaternion::about(&self.axis, q[0]))
    }

    fn coordinates(&self) -> [JointCoordinate; 1] {
        [("angle", Quantity::Angle)]
    }
}
