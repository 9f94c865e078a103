//! The constant-velocity joint: the shafts turn equally fast at any angle between them.

use super::axes::across;
use super::{AxisError, Joint, JointCoordinate, PARALLEL, Pose, direction};
use nalgebra::{SVector, Vector3};
use pullback_manifold::domain::DomainError;
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::quaternion;
use pullback_manifold::system::Quantity;

/// R_s = R_m R(τ₀ + α a + β b) R(τ₀)ᵀ with a, b across the first shaft: parents (frame, tilt 1,
/// tilt 2). τ₀ tilts the first shaft into the second one in the reference configuration.
///
/// The rotation vector from shafts in line has no component along the shaft, so the plane that
/// halves the angle between the shafts is one of symmetry: the condition for equal speeds. The
/// tilt must stay below 2π.
///
#[doc = include_str!("../../images/constant_velocity.svg")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstantVelocity {
    across: [Vector3<f64>; 2],
    tilt: Vector3<f64>,
}

impl ConstantVelocity {
    /// The coupling of two shafts along axes of any length: the first axis points towards the joint, the
    /// second away from it. An error for axes without a direction, or in opposite directions.
    pub fn new(axes: [[f64; 3]; 2]) -> Result<Self, AxisError> {
        let [e, f] = [direction(axes[0])?, direction(axes[1])?];
        let first = across(&e);
        let across = [first, e.cross(&first)];
        let (turn, cosine) = (e.cross(&f), e.dot(&f));
        let sine = turn.norm();
        if sine < PARALLEL && cosine < 0.0 {
            return Err(AxisError::Opposite);
        }
        let angle = sine.atan2(cosine);
        let tilt = turn * if sine > 0.0 { angle / sine } else { 1.0 };
        Ok(Self { across, tilt })
    }

    fn angle<S: Scalar>(&self, alpha: S, beta: S) -> Vector3<S> {
        let [a, b] = self.across.map(|e| e.map(S::constant));
        self.tilt.map(S::constant) + a * alpha + b * beta
    }
}

impl Joint<2> for ConstantVelocity {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 2>) -> Pose<S> {
        let back = -self.tilt.map(S::constant);
        Pose::identity()
            .rotated(&quaternion(&self.angle(q[0], q[1])))
            .rotated(&quaternion(&back))
    }

    fn coordinates(&self) -> [JointCoordinate; 2] {
        [("tilt 1", Quantity::Angle), ("tilt 2", Quantity::Angle)]
    }

    fn domain(&self, _t: f64, q: &SVector<f64, 2>) -> Result<f64, DomainError> {
        let margin = std::f64::consts::TAU - self.angle(q[0], q[1]).norm();
        DomainError::within(
            margin,
            "its tilts of less than a whole turn: stop before, or take two joints",
        )
    }
}
