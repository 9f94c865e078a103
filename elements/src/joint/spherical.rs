//! The spherical joint: two frames share a position and turn freely against each other.

use super::{Joint, JointCoordinate, Pose};
use nalgebra::SVector;
use pullback_manifold::scalar::Scalar;

/// d_s = d_m, Ψ_s of its own: parents (frame, rotation).
///
/// Its child turns freely ([`ModelBuilder::attach_free`](crate::model::ModelBuilder::attach_free)): the
/// coordinates are the child's own rotation vector, in global components and not relative to the parent, and
/// the chart changes at ψ > π.
///
#[doc = include_str!("../../images/spherical.svg")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spherical;

impl Joint<0> for Spherical {
    fn pose<S: Scalar>(&self, _t: S, _q: &SVector<S, 0>) -> Pose<S> {
        Pose::identity()
    }

    fn coordinates(&self) -> [JointCoordinate; 0] {
        []
    }
}
