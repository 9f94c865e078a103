//! A point on a space curve that its parent carries.

use super::{Joint, JointNodes, Pose, Released};
use crate::model::{ModelBuilder, ModelError, NodeId};
use nalgebra::{SVector, Vector3};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::quaternion;

/// A space curve, written once over any [`Scalar`].
pub trait Curve: Send + Sync {
    /// The point of a parameter, as seen from the parent's node in the reference configuration
    /// (global components).
    fn at<S: Scalar>(&self, s: S) -> Vector3<S>;

    /// Distance of a parameter to the end of the curve; infinite by default.
    fn margin(&self, s: f64) -> f64 {
        let _ = s;
        f64::INFINITY
    }

    /// Where the curve is pieced together from several formulas, keeps to the one that holds at s,
    /// beyond its ends too, or to none again: what [`check`](crate::check) compares derivatives
    /// with. Nothing to do by default, for a curve with three continuous derivatives.
    fn freeze_piece(&mut self, at: Option<f64>) {
        let _ = at;
    }
}

/// d_s = d_m + R_m x(s) − x(0), Ψ_s of its own: parents (frame, parameter s, rotation).
///
#[doc = include_str!("../../../docs/images/joints/on_curve.svg")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnCurve<C> {
    curve: C,
    /// x(0), also while the curve keeps to a piece that is elsewhere.
    start: Vector3<f64>,
}

impl<C: Curve> OnCurve<C> {
    /// The joint of a curve.
    pub fn new(curve: C) -> Self {
        let start = curve.at(0.0);
        Self { curve, start }
    }
}

impl<C: Curve> Joint<10> for OnCurve<C> {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 10>) -> Pose<S> {
        let carried = Pose::of(q, 0).translated(&self.curve.at(q[6]));
        Pose {
            d: carried.d - self.start.map(S::constant),
            rotation: quaternion(&Vector3::new(q[7], q[8], q[9])),
        }
    }

    fn released(&self) -> &'static [Released] {
        const { &[Released::parameter("parameter"), Released::Rotation] }
    }

    fn margin(&self, _t: f64, q: &SVector<f64, 10>) -> f64 {
        self.curve.margin(q[6])
    }

    fn freeze_piece(&mut self, at: Option<(f64, &SVector<f64, 10>)>) {
        self.curve.freeze_piece(at.map(|(_, q)| q[6]));
    }

    fn edge(&self) -> &'static str {
        "its curve over an end: make it longer, or stop before"
    }
}

/// Adds a frame node `name` that runs along a curve carried by `parent`, from its parameter 0, and
/// turns freely; and the nodes `name parameter` and `name rotation`.
///
/// # Errors
/// As [`ModelBuilder::mapped_node`].
pub fn on_curve<C: Curve + Clone + 'static>(
    b: &mut ModelBuilder,
    name: &str,
    parent: NodeId,
    curve: C,
) -> Result<JointNodes, ModelError> {
    let joint = OnCurve::new(curve);
    let position = b.position(parent) + joint.start;
    b.join(name, position.into(), joint, &[parent])
}
