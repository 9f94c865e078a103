//! The revolute joint: two frames share a position and an axis; the angle between them is unbounded.

mod closed;

use super::{AxisError, Joint, LogBranch, Pose, Released, RevoluteNodes, direction};
use crate::model::{ModelBuilder, ModelError, NodeId};
use nalgebra::{SMatrix, SVector, Vector3, Vector6};
use pullback_manifold::map::Kinematics;
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::{self, Quaternion};

/// d_s = d_m, R_s = R_m R(φ e): parents (frame, angle φ); \[M04\] 4.1.4.
///
#[doc = include_str!("../../../docs/images/joints/revolute.svg")]
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

impl Joint<7> for Revolute {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 7>) -> Pose<S> {
        let parent = so3::quaternion(&Vector3::new(q[3], q[4], q[5]));
        Pose {
            d: Vector3::new(q[0], q[1], q[2]),
            rotation: parent.product(&Quaternion::about(&self.axis, q[6])),
        }
    }

    fn released(&self) -> &'static [Released] {
        const { &[Released::angle("angle")] }
    }

    fn kinematics(
        &self,
        branch: LogBranch,
        _t: f64,
        q: &SVector<f64, 7>,
        v: &SVector<f64, 7>,
        a: &SVector<f64, 7>,
    ) -> Option<Kinematics<7, 6>> {
        Some(closed::kinematics(self, branch, q, v, a))
    }

    fn geometric_stiffness(
        &self,
        branch: LogBranch,
        _t: f64,
        q: &SVector<f64, 7>,
        f: &Vector6<f64>,
    ) -> Option<SMatrix<f64, 7, 7>> {
        Some(closed::geometric_stiffness(self, branch, q, f))
    }
}

/// Adds a frame node `name` at the position of `parent` that turns about `axis` (global components
/// of the reference configuration, carried by the parent), and the node `name angle`.
///
/// # Errors
/// [`ModelError::Axis`] for an axis without a direction; as [`ModelBuilder::mapped_node`].
pub fn revolute(
    b: &mut ModelBuilder,
    name: &str,
    parent: NodeId,
    axis: [f64; 3],
) -> Result<RevoluteNodes, ModelError> {
    let joint = Revolute::new(axis).map_err(|e| e.of(name))?;
    let made = b.attach(name, parent, joint)?;
    let (frame, angle) = (made.frame, made.released[0]);
    Ok(RevoluteNodes { frame, angle })
}
