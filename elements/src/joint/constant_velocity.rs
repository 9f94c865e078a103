//! The constant-velocity joint: the shafts turn equally fast at any angle between them.

use super::{Joint, JointNodes, Pose, Released, direction};
use crate::model::{ModelBuilder, ModelError, NodeId};
use nalgebra::{SVector, Vector3};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::quaternion;

/// R_s = R_m R(α a + β b) with a, b across the shaft: masters (frame, tilt 1, tilt 2).
///
/// The relative rotation vector has no component along the shaft, so the plane that halves the
/// angle between the shafts is one of symmetry: the condition for equal speeds. The tilt must stay
/// below 2π.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstantVelocity {
    across: [Vector3<f64>; 2],
}

impl ConstantVelocity {
    /// The coupling of shafts along an axis of any length; `None` for one without a direction.
    pub fn new(axis: [f64; 3]) -> Option<Self> {
        let axis = direction("", axis).ok()?;
        let first = axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize();
        let across = [first, axis.cross(&first)];
        Some(Self { across })
    }
}

impl Joint<8> for ConstantVelocity {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 8>) -> Pose<S> {
        let [a, b] = self.across.map(|e| e.map(S::constant));
        Pose::of(q, 0).turned(&quaternion(&(a * q[6] + b * q[7])))
    }

    fn released(&self) -> &'static [Released] {
        const { &[Released::angle("tilt 1"), Released::angle("tilt 2")] }
    }

    fn margin(&self, _t: f64, q: &SVector<f64, 8>) -> f64 {
        std::f64::consts::TAU - q[6].hypot(q[7])
    }
}

/// Adds a frame node `name` at the place of `master`, coupled to it at constant velocity for
/// shafts along `axis` (global components of the reference configuration), and the nodes
/// `name tilt 1` and `name tilt 2`.
///
/// # Errors
/// [`ModelError::Axis`] for an axis without a direction; as [`ModelBuilder::mapped_node`].
pub fn constant_velocity(
    b: &mut ModelBuilder,
    name: &str,
    master: NodeId,
    axis: [f64; 3],
) -> Result<JointNodes, ModelError> {
    direction(name, axis)?;
    let joint = ConstantVelocity::new(axis);
    let joint = joint.ok_or_else(|| ModelError::Axis {
        joint: name.to_owned(),
        axis,
    })?;
    b.join(name, b.place(master).into(), joint, &[master])
}
