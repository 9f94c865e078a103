//! The prismatic joint: a displacement along an axis, no turn.

use super::{AxisError, Joint, JointCoordinate, JointNodes, Pose, direction};
use crate::model::{ModelBuilder, ModelError, NodeId};
use nalgebra::{SVector, Vector3};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::system::Quantity;

/// d_s = d_m + R_m u e, R_s = R_m: parents (frame, displacement u).
///
#[doc = include_str!("../../../docs/images/joints/prismatic.svg")]
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
        Pose::identity().translated(&(self.axis.map(S::constant) * q[0]))
    }

    fn coordinates(&self) -> [JointCoordinate; 1] {
        [("displacement", Quantity::Length)]
    }
}

/// Adds a frame node `name` at the position of `parent` that slides along `axis` (global components
/// of the reference configuration, carried by the parent), and the node `name displacement`.
///
/// # Errors
/// [`ModelError::Axis`] for an axis without a direction; as [`ModelBuilder::mapped_node`].
pub fn prismatic(
    b: &mut ModelBuilder,
    name: &str,
    parent: NodeId,
    axis: [f64; 3],
) -> Result<JointNodes, ModelError> {
    let joint = Prismatic::new(axis).map_err(|e| e.of(name))?;
    b.attach(name, parent, joint)
}
