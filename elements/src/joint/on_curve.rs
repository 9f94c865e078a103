//! A joint along a space curve that is fixed to the parent.

use super::{Joint, JointCoordinate, Pose};
use nalgebra::{SVector, Vector3};
use pullback_manifold::domain::DomainError;
use pullback_manifold::scalar::Scalar;
use pullback_manifold::system::Quantity;

/// A space curve, written once over any [`Scalar`].
pub trait Curve: Send + Sync {
    /// The point of a parameter, as seen from the parent's node in the reference configuration
    /// (global components).
    fn at<S: Scalar>(&self, s: S) -> Vector3<S>;

    /// What the parameter is, such as a length for the arc length; neither a length nor an angle by default.
    /// Such a parameter should be scaled to changes of about one: the errors of adaptive steps are measured by it.
    fn quantity(&self) -> Quantity {
        Quantity::Other
    }

    /// Distance of a parameter to the end of the curve; infinite by default.
    fn margin(&self, s: f64) -> f64 {
        let _ = s;
        f64::INFINITY
    }

    /// Freezes a curve with several pieces to the one at s, also beyond its ends, or releases it: the
    /// conformance kit compares derivatives with it. Nothing by default, for a curve with three continuous
    /// derivatives.
    fn freeze_piece(&mut self, at: Option<f64>) {
        let _ = at;
    }
}

/// d_s = d_m + R_m x(s) − x(0): the coordinate is the parameter s.
///
#[doc = include_str!("../../images/on_curve.svg")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnCurve<C> {
    curve: C,
}

impl<C: Curve> OnCurve<C> {
    /// The joint of a curve.
    pub fn new(curve: C) -> Self {
        Self { curve }
    }
}

impl<C: Curve> Joint<1> for OnCurve<C> {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 1>) -> Pose<S> {
        Pose::from_translation(self.curve.at(q[0]))
    }

    fn coordinates(&self) -> [JointCoordinate; 1] {
        [("parameter", self.curve.quantity())]
    }

    fn domain(&self, _t: f64, q: &SVector<f64, 1>) -> Result<f64, DomainError> {
        let margin = self.curve.margin(q[0]);
        DomainError::within(
            margin,
            "its curve over an end: make it longer, or stop before",
        )
    }

    fn freeze_piece(&mut self, at: Option<(f64, &SVector<f64, 1>)>) {
        self.curve.freeze_piece(at.map(|(_, q)| q[0]));
    }
}
