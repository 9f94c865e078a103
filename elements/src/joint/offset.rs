//! The rigid link: a frame fixed to another one at a distance.

#![allow(non_snake_case)]

use super::{Joint, LogBranch, Pose};
use crate::model::{ModelBuilder, ModelError, NodeId};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3, Vector6};
use pullback_manifold::quotients::Quotients;
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::{self, skew};

/// d_s = d_m + (R_m − I) c, Ψ_s = Ψ_m (\[M04\] 4.1.2): parents (frame).
///
#[doc = include_str!("../../../docs/images/joints/offset.svg")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offset {
    /// Vector from the parent to the dependent in the reference configuration, global components.
    pub c: Vector3<f64>,
}

impl Joint<6> for Offset {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 6>) -> Pose<S> {
        Pose::of(q, 0).offset(&self.c)
    }

    /// \[M04\] (197).
    fn geometric_stiffness(
        &self,
        branch: LogBranch,
        _t: f64,
        q: &SVector<f64, 6>,
        f: &Vector6<f64>,
    ) -> Option<SMatrix<f64, 6, 6>> {
        // On the other branch the moment goes through the complement map as well.
        if branch == LogBranch::Opposite {
            return None;
        }
        let psi = Vector3::new(q[3], q[4], q[5]);
        let quotients = Quotients::new(psi.norm());
        let c = quotients.tangent();
        let (R, T) = (so3::R(&psi, &c), so3::T(&psi, &c));
        let g = R.tr_mul(&Vector3::new(f[0], f[1], f[2]));
        let turning: Matrix3<f64> = so3::C2(&self.c.cross(&g), &psi, &quotients)
            + T.tr_mul(&(skew(&self.c) * skew(&g) * T));
        let mut K = SMatrix::<f64, 6, 6>::zeros();
        K.fixed_view_mut::<3, 3>(3, 3).copy_from(&turning);
        Some(K)
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
    b.add_joint_frame(name, position, Offset { c }, &[parent])
}

/// Adds a frame node `name` welded to `parent`, at its place.
///
#[doc = include_str!("../../../docs/images/joints/weld.svg")]
///
/// # Errors
/// As [`ModelBuilder::mapped_node`].
pub fn weld(b: &mut ModelBuilder, name: &str, parent: NodeId) -> Result<NodeId, ModelError> {
    let position = b.position(parent).into();
    offset(b, name, parent, position)
}
