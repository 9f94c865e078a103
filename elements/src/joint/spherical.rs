//! The spherical joint: two frames share a position and turn freely against each other.

use super::{Joint, JointCoordinate, JointNodes, Pose};
use crate::model::{ModelBuilder, ModelError, NodeId};
use nalgebra::SVector;
use pullback_manifold::scalar::Scalar;

/// d_s = d_m, Ψ_s of its own: parents (frame, rotation).
///
/// Its child turns freely ([`ModelBuilder::attach_free`]): the coordinates are the child's own rotation
/// vector, in global components and not relative to the parent, and the chart changes at ψ > π.
///
#[doc = include_str!("../../../docs/images/joints/spherical.svg")]
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

/// The nodes of a spherical joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SphericalNodes {
    /// The frame that is attached to the joint.
    pub frame: NodeId,
    /// Its rotation vector, the coordinates of the joint.
    pub rotation: NodeId,
}

/// Adds a frame node `name` at the position of `parent` that turns freely, and the node
/// `name rotation` of its rotation vector.
///
/// # Errors
/// As [`ModelBuilder::mapped_node`].
pub fn spherical(
    b: &mut ModelBuilder,
    name: &str,
    parent: NodeId,
) -> Result<SphericalNodes, ModelError> {
    let JointNodes { frame, coordinates } = b.attach_free(name, parent, Spherical)?;
    let rotation = coordinates[0];
    Ok(SphericalNodes { frame, rotation })
}
