//! The free joint: six coordinates relative to another frame.

use super::{Joint, JointCoordinate, Pose};
use nalgebra::{SVector, Vector3};
use pullback_manifold::domain::{CHART_EDGE, DomainError};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::system::Quantity;
use std::f64::consts::TAU;

/// d_s = d_m + R_m (c + u) − c, R_s = R_m R(θ): parents (frame, displacement u, rotation vector θ).
///
#[doc = include_str!("../../images/free.svg")]
///
/// What rotates with the parent is at rest in these coordinates, so that its
/// mass, damping and stiffness are constant. As a node ([`ModelBuilder::relative_node`](crate::model::ModelBuilder::relative_node))
/// its rotation vector changes its chart at ψ > π.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free {
    /// Vector from the parent to the child in the reference configuration, global components.
    pub c: Vector3<f64>,
}

impl Joint<6> for Free {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 6>) -> Pose<S> {
        let relative = Pose::of(q, 0);
        Pose {
            d: self.c.map(S::constant) + relative.d,
            ..relative
        }
    }

    fn coordinates(&self) -> [JointCoordinate; 6] {
        let (length, angle) = (Quantity::Length, Quantity::Angle);
        [
            ("x", length),
            ("y", length),
            ("z", length),
            ("rx", angle),
            ("ry", angle),
            ("rz", angle),
        ]
    }

    fn domain(&self, _t: f64, q: &SVector<f64, 6>) -> Result<f64, DomainError> {
        let angle = q.fixed_rows::<3>(3).norm();
        DomainError::within(TAU - angle, CHART_EDGE)
    }
}
