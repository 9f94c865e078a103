//! The universal (Hooke's, Cardan) joint: two turns about crossed axes.

use super::{Joint, JointNodes, PARALLEL, Pose, Released, direction};
use crate::model::{ModelBuilder, ModelError, NodeId};
use nalgebra::{SVector, Vector3};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::Quaternion;

/// R_s = R_m R(α e₁) R(β e₂): masters (frame, angle 1, angle 2).
///
/// The first axis is fixed in the master, the second in the slave. Nothing is singular in this
/// description; at β = ±90° with axes at right angles a shaft across both would be locked, which a
/// loop of such shafts shows as a singular tangent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Universal {
    axes: [Vector3<f64>; 2],
}

impl Universal {
    /// The joint with two axes of any length, in global components of the reference configuration;
    /// `None` for axes without a direction or along each other.
    pub fn new(axes: [[f64; 3]; 2]) -> Option<Self> {
        let [a, b] = [direction("", axes[0]).ok()?, direction("", axes[1]).ok()?];
        (a.cross(&b).norm() > PARALLEL).then_some(Self { axes: [a, b] })
    }
}

impl Joint<8> for Universal {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 8>) -> Pose<S> {
        Pose::of(q, 0)
            .turned(&Quaternion::about(&self.axes[0], q[6]))
            .turned(&Quaternion::about(&self.axes[1], q[7]))
    }

    fn released(&self) -> &'static [Released] {
        const { &[Released::angle("angle 1"), Released::angle("angle 2")] }
    }
}

/// Adds a frame node `name` at the place of `master` on a cross with two axes (global components
/// of the reference configuration; the master carries the first), and the nodes `name angle 1`
/// and `name angle 2`.
///
/// # Errors
/// [`ModelError::Axis`] for axes without a direction, or along each other.
pub fn universal(
    b: &mut ModelBuilder,
    name: &str,
    master: NodeId,
    axes: [[f64; 3]; 2],
) -> Result<JointNodes, ModelError> {
    for axis in axes {
        direction(name, axis)?;
    }
    let parallel = || ModelError::Parallel {
        joint: name.to_owned(),
    };
    let joint = Universal::new(axes).ok_or_else(parallel)?;
    b.join(name, b.place(master).into(), joint, &[master])
}
