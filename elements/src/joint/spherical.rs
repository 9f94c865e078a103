//! The spherical joint: two frames share a position and turn freely against each other.

use super::{Joint, JointNodes, Pose, Released};
use crate::model::{ModelBuilder, ModelError, NodeId};
use nalgebra::{SVector, Vector3};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::quaternion;

/// d_s = d_m, Ψ_s of its own: parents (frame, rotation).
///
/// The released coordinates are the dependent's own rotation vector, in global components and not
/// relative to the parent: nothing couples the rotations, and the chart changes at ψ > π.
///
#[doc = include_str!("../../../docs/images/joints/spherical.svg")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spherical;

impl Joint<9> for Spherical {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 9>) -> Pose<S> {
        Pose {
            d: Vector3::new(q[0], q[1], q[2]),
            rotation: quaternion(&Vector3::new(q[6], q[7], q[8])),
        }
    }

    fn released(&self) -> &'static [Released] {
        const { &[Released::Rotation] }
    }
}

/// The nodes of a spherical joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SphericalNodes {
    /// The frame that is attached to the joint.
    pub frame: NodeId,
    /// Its rotation vector: the released coordinates.
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
    let JointNodes { frame, released } = b.attach(name, parent, Spherical)?;
    let rotation = released[0];
    Ok(SphericalNodes { frame, rotation })
}
