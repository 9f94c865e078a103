//! The rigid link: a frame fixed to another one at a distance.

use super::{Joint, JointCoordinate, Pose};
use nalgebra::{SVector, Vector3};
use pullback_manifold::scalar::Scalar;

/// d_s = d_m + (R_m − I) c, Ψ_s = Ψ_m (\[M04\] 4.1.2): parents (frame).
///
#[doc = include_str!("../../images/offset.svg")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offset {
    /// Vector from the parent to the child in the reference configuration, global components.
    pub c: Vector3<f64>,
}

impl Joint<0> for Offset {
    fn pose<S: Scalar>(&self, _t: S, _q: &SVector<S, 0>) -> Pose<S> {
        Pose::from_translation(self.c.map(S::constant))
    }

    fn coordinates(&self) -> [JointCoordinate; 0] {
        []
    }
}
