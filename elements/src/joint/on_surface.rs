//! A joint on a surface that is fixed to the parent.

use super::{Joint, JointCoordinate, Pose};
use nalgebra::{SVector, Vector3};
use pullback_manifold::domain::DomainError;
use pullback_manifold::scalar::Scalar;
use pullback_manifold::system::Quantity;

/// A surface, written once over any [`Scalar`].
pub trait Surface: Send + Sync {
    /// The point of two parameters, as seen from the parent's node in the reference configuration
    /// (global components).
    fn at<S: Scalar>(&self, u: S, v: S) -> Vector3<S>;

    /// What the parameters are: neither lengths nor angles by default.
    fn quantities(&self) -> [Quantity; 2] {
        [Quantity::Other; 2]
    }

    /// Distance of the parameters to the edge of the surface; infinite by default.
    fn margin(&self, u: f64, v: f64) -> f64 {
        let _ = (u, v);
        f64::INFINITY
    }
}

/// d_s = d_m + R_m x(u, v) − x(0, 0): the coordinates are the parameters u and v.
///
#[doc = include_str!("../../images/on_surface.svg")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnSurface<F> {
    surface: F,
}

impl<F> OnSurface<F> {
    /// The joint of a surface.
    pub fn new(surface: F) -> Self {
        Self { surface }
    }
}

impl<F: Surface> Joint<2> for OnSurface<F> {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 2>) -> Pose<S> {
        Pose::from_translation(self.surface.at(q[0], q[1]))
    }

    fn coordinates(&self) -> [JointCoordinate; 2] {
        let [first, second] = self.surface.quantities();
        [("parameter 1", first), ("parameter 2", second)]
    }

    fn domain(&self, _t: f64, q: &SVector<f64, 2>) -> Result<f64, DomainError> {
        let margin = self.surface.margin(q[0], q[1]);
        DomainError::within(
            margin,
            "its surface over an edge, or at a pole of its coordinates: make it larger, start elsewhere or stop before",
        )
    }
}
