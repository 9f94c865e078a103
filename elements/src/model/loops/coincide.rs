//! The equations that two frames coincide.

use crate::joint::Pose;
use nalgebra::{SVector, Vector3};
use pullback_manifold::map::Map;
use pullback_manifold::scalar::Scalar;

/// Two coinciding frames: the gap to frame a in the axes of frame b, and twice the vector part of
/// the quaternion with a positive scalar part that rotates b to a; independent of the branches of
/// the rotation vectors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::model) struct Coincide {
    /// From b to a in the reference configuration.
    pub apart: Vector3<f64>,
}

impl Map<12, 6> for Coincide {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 12>) -> SVector<S, 6> {
        let (a, b) = (Pose::of(q, 0), Pose::of(q, 6));
        let back = b.rotation.conjugate();
        let gap = back.rotate(&(a.d - b.d + self.apart.map(S::constant)));
        let turn = back.product(&a.rotation);
        let turn = turn.v * S::constant(2.0_f64.copysign(turn.w.re()));
        SVector::<S, 6>::new(gap.x, gap.y, gap.z, turn.x, turn.y, turn.z)
    }
}
