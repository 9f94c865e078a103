//! The rigid link: a frame fixed to another one at a distance.

use super::{Joint, JointCoordinate, Pose};
use crate::model::{ModelBuilder, ModelError, NodeId};
use nalgebra::{SVector, Vector3};
use pullback_manifold::scalar::Scalar;

/// d_s = d_m + (R_m − I) c, Ψ_s = Ψ_m (\[M04\] 4.1.2): parents (frame).
///
#[doc = include_str!("../../../docs/images/joints/offset.svg")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offset {
    /// Vector from the parent to the child in the reference configuration, global components.
    pub c: Vector3<f64>,
}

impl Joint<0> for Offset {
    fn pose<S: Scalar>(&self, _t: S, _q: &SVector<S, 0>) -> Pose<S> {
        Pose::identity().translated(&self.c.map(S::constant))
    }

    fn coordinates(&self) -> [JointCoordinate; 0] {
        []
    }
}

/// Adds a frame node fixed to `parent` at a distance: it stands at `position` in the reference
/// configuration.
///
/// # Errors
/// As [`ModelBuilder::mapped_node`].
pub fn offset(
    b: &mut ModelBuilder,
    name: &str,
    parent: NodeId,
    position: [f64; 3],
) -> Result<NodeId, ModelError> {
    let c = Vector3::from(position) - b.position(parent);
    Ok(b.attach(name, parent, Offset { c })?.frame)
}

/// Adds a frame node `name` welded to `parent`, at its position.
///
#[doc = include_str!("../../../docs/images/joints/weld.svg")]
///
/// # Errors
/// As [`ModelBuilder::mapped_node`].
pub fn weld(b: &mut ModelBuilder, name: &str, parent: NodeId) -> Result<NodeId, ModelError> {
    let position = b.position(parent).into();
    offset(b, name, parent, position)
}
