//! Joints: a joint is the pose of its child in its parent.
//!
//! A joint is defined by [`Joint::pose`]; the kinematic operator, its rates and the geometric stiffness follow
//! ([`JointMap`]). Its child is a frame for any element. There are no multipliers: the coordinates of a joint
//! are coordinates of the model.
//!
//! | joint | coordinates | source |
//! |---|---|---|
//! | [`Offset`] | none | \[M04\] 4.1.2, (197) |
//! | [`Revolute`] | one unbounded angle | \[M04\] 4.1.4, (207), (212) |
//! | [`ModelBuilder::spherical`](crate::model::ModelBuilder::spherical) | a rotation vector | \[M04\] 4.1 |
//! | [`Slide`] | the position on a chain of beam elements | \[M04\] 4.1.3, (198) |
//! | [`Universal`] | two angles, about crossed axes | Shabana 2013, 3.3 |
//! | [`ConstantVelocity`] | two components of a rotation vector across the shaft | Myszka & Murray 2010 |
//! | [`Cylindrical`] | displacement and angle along and about one axis | Shabana 2013, 3.3 |
//! | [`Prismatic`] | the displacement along an axis | Shabana 2013, 3.3 |
//! | [`Planar`] | two displacements in a plane, the angle about its normal | Shabana 2013, 3.3 |
//! | [`Helical`] | the angle of a screw | Shabana 2013, 3.3 |
//! | [`Free`] | three displacements and a rotation vector relative to the parent | Shabana 2013, 3.3 |
//! | [`OnCurve`] | the parameter of a space curve ([`Spline`], or any [`Curve`]), and all rotations | |
//! | [`OnSurface`] | two parameters of a surface ([`Quadric`], or any [`Surface`]), and all rotations | |
//! | [`ModelBuilder::gear`](crate::model::ModelBuilder::gear) | none: it couples coordinates of two joints | Shabana 2013, 3.3 |

mod axes;
mod constant_velocity;
mod cylindrical;
mod free;
mod gear;
mod helical;
mod link;
mod map;
mod nodes;
mod offset;
mod on_curve;
mod on_surface;
mod planar;
mod prismatic;
mod revolute;
mod shape;
mod slide;
mod universal;

pub use axes::AxisError;
pub use constant_velocity::ConstantVelocity;
pub use cylindrical::Cylindrical;
pub use free::Free;
pub use gear::GearError;
pub use helical::Helical;
pub use map::JointMap;
pub use nodes::JointNodes;
pub use offset::Offset;
pub use on_curve::{Curve, OnCurve};
pub use on_surface::{OnSurface, Surface};
pub use planar::Planar;
pub use prismatic::Prismatic;
pub use revolute::Revolute;
pub use shape::{Chain, Quadric, Spline, SplineError};
pub use slide::Slide;
pub use universal::Universal;

use axes::{PARALLEL, direction};
use nalgebra::{SVector, Vector3};
use pullback_manifold::domain::DomainError;
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::{Quaternion, quaternion};
use pullback_manifold::system::Quantity;

/// The pose of a child frame in its parent.
///
/// The rotation is a unit quaternion, which composes without a chart; a quaternion and its opposite are the same rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<S> {
    /// Position of the child from the parent, in the parent's axes.
    pub d: Vector3<S>,
    /// Rotation from the parent's axes to the child's.
    pub rotation: Quaternion<S>,
}

impl<S: Scalar> Pose<S> {
    /// The pose of the parent itself.
    #[inline]
    pub fn identity() -> Self {
        let zero = || Vector3::new(S::zero(), S::zero(), S::zero());
        Self {
            d: zero(),
            rotation: Quaternion {
                w: S::one(),
                v: zero(),
            },
        }
    }

    /// A translation, in the parent's axes.
    pub fn from_translation(by: Vector3<S>) -> Self {
        Self {
            d: by,
            ..Self::identity()
        }
    }

    /// A rotation.
    pub fn from_rotation(by: Quaternion<S>) -> Self {
        Self {
            rotation: by,
            ..Self::identity()
        }
    }

    /// The displacement and the rotation of a frame with the six coordinates (d, Ψ) in `q` from index
    /// `first` on, for maps of several frames.
    pub fn of<const D: usize>(q: &SVector<S, D>, first: usize) -> Self {
        let three = |k: usize| Vector3::new(q[k], q[k + 1], q[k + 2]);
        Self {
            d: three(first),
            rotation: quaternion(&three(first + 3)),
        }
    }

    /// The same position, rotated further about axes of this frame: R R(by).
    #[must_use]
    pub fn rotated(&self, by: &Quaternion<S>) -> Self {
        Self {
            d: self.d,
            rotation: self.rotation.product(by),
        }
    }

    /// The same orientation, translated by a vector in the axes of this frame.
    #[must_use]
    pub fn translated(&self, by: &Vector3<S>) -> Self {
        Self {
            d: self.d + self.rotation.rotate(by),
            rotation: self.rotation,
        }
    }
}

/// A coordinate of a joint: its name, appended to that of the joint, and its quantity.
pub type JointCoordinate = (&'static str, Quantity);

/// A joint: the pose of its child in its parent, a function of D coordinates of its own and of time.
///
/// In the reference configuration, where the coordinates and the time are zero, the axes of both frames
/// are those of the fixed frame.
pub trait Joint<const D: usize>: Send + Sync {
    /// The pose, written once over any [`Scalar`]; smooth in t. A motion with kinks belongs in a coordinate that is
    /// prescribed, whose function names them ([`TimeFunction::kinks`](crate::time::TimeFunction::kinks)).
    fn pose<S: Scalar>(&self, t: S, q: &SVector<S, D>) -> Pose<S>;

    /// Its coordinates in order, with different names.
    fn coordinates(&self) -> [JointCoordinate; D];

    /// Distance of q to the edge of the domain of the joint, by [`DomainError::within`]; infinite by
    /// default. The rotation vector of the child needs none: it changes its chart.
    ///
    /// # Errors
    /// [`DomainError`] outside, with words that follow "the joint left".
    fn domain(&self, t: f64, q: &SVector<f64, D>) -> Result<f64, DomainError> {
        let _ = (t, q);
        Ok(f64::INFINITY)
    }

    /// Freezes a pose with several pieces to the one at (t, q), or releases it; nothing by default. See
    /// [`MapState::freeze_piece`](pullback_manifold::map::MapState::freeze_piece).
    fn freeze_piece(&mut self, at: Option<(f64, &SVector<f64, D>)>) {
        let _ = at;
    }
}
