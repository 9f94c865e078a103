//! Joints: holonomic constraints as maps from the coordinates a frame depends on to the frame.
//!
//! Whoever writes [`Joint::pose`] has a joint: the node that is attached to it takes any element, the
//! kinematic operator, its rates and the geometric stiffness follow ([`JointMap`], [`Map`]). There are
//! no multipliers: the coordinates that a joint releases are coordinates of the model.
//!
//! | joint | released coordinates | source |
//! |---|---|---|
//! | [`Offset`], [`weld`] | none | \[M04\] 4.1.2, (197) |
//! | [`Revolute`] | one unbounded angle | \[M04\] 4.1.4, (207), (212) |
//! | [`Spherical`] | a rotation vector | \[M04\] 4.1 |
//! | [`Slide`] | the position on a chain of beam elements | \[M04\] 4.1.3, (198) |
//! | [`Universal`] | two angles, about crossed axes | Shabana 2013, 3.3 |
//! | [`ConstantVelocity`] | two components of a rotation vector across the shaft | Myszka & Murray 2010 |
//! | [`Cylindrical`] | displacement and angle along and about one axis | Shabana 2013, 3.3 |
//! | [`Prismatic`] | the displacement along an axis | Shabana 2013, 3.3 |
//! | [`Planar`] | two ways in a plane, the angle about its normal | Shabana 2013, 3.3 |
//! | [`Helical`] | the angle of a screw | Shabana 2013, 3.3 |
//! | [`OnCurve`] | the parameter of a space curve ([`Spline`], or any [`Curve`]), and all rotations | |
//! | [`OnSurface`] | two parameters of a surface ([`Quadric`], or any [`Surface`]), and all rotations | |
//! | [`gear`], [`rack`] | none: they couple what two joints release | Shabana 2013, 3.3 |

mod axes;
mod constant_velocity;
mod cylindrical;
mod gear;
mod helical;
mod nodes;
mod offset;
mod on_curve;
mod on_surface;
mod planar;
mod prismatic;
mod revolute;
mod shape;
mod slide;
mod spherical;
mod universal;

pub use axes::AxisError;
pub use constant_velocity::{ConstantVelocity, constant_velocity};
pub use cylindrical::{Cylindrical, cylindrical};
pub use gear::{GearError, gear, rack};
pub use helical::{Helical, helical};
pub use nodes::{JointNodes, RevoluteNodes, SlideNodes, slide, slide_on};
pub use offset::{Offset, offset, weld};
pub use on_curve::{Curve, OnCurve, on_curve};
pub use on_surface::{OnSurface, Surface, on_surface};
pub use planar::{Planar, planar};
pub use prismatic::{Prismatic, prismatic};
pub use revolute::{Revolute, revolute};
pub use shape::{Between, Chain, Quadric, Spline, SplineError};
pub use slide::Slide;
pub use spherical::{Spherical, SphericalNodes, spherical};
pub use universal::{Universal, universal};

use axes::{PARALLEL, direction};
use nalgebra::{SMatrix, SVector, Vector3, Vector6};
use pullback_manifold::map::{Kinematics, Map, derived};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::{Quaternion, log_quaternion, quaternion};
use pullback_manifold::system::{CHART_EDGE, ChartChanges, Quantity};
use std::f64::consts::TAU;

/// Displacement and rotation of a frame from its reference, in global components.
///
/// The rotation is a quaternion, which composes without a chart; q and −q are the same rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<S> {
    /// Displacement d.
    pub d: Vector3<S>,
    /// Rotation, of unit length.
    pub rotation: Quaternion<S>,
}

impl<S: Scalar> Pose<S> {
    /// The frame whose six coordinates (d, Ψ) stand in `q` from position `first` on.
    pub fn of<const D: usize>(q: &SVector<S, D>, first: usize) -> Self {
        let three = |k: usize| Vector3::new(q[k], q[k + 1], q[k + 2]);
        Self {
            d: three(first),
            rotation: quaternion(&three(first + 3)),
        }
    }

    /// A frame fixed in this one, at `c` from it in the reference configuration:
    /// d_s = d + (R − I) c.
    #[must_use]
    pub fn offset(&self, c: &Vector3<f64>) -> Self {
        let c = c.map(S::constant);
        Self {
            d: self.d + self.rotation.rotate(&c) - c,
            rotation: self.rotation,
        }
    }

    /// The same position, rotated further about axes that this frame carries: R R(by).
    #[must_use]
    pub fn rotated(&self, by: &Quaternion<S>) -> Self {
        Self {
            d: self.d,
            rotation: self.rotation.product(by),
        }
    }

    /// The same orientation, translated by a vector of this frame (components of the reference).
    #[must_use]
    pub fn translated(&self, by: &Vector3<S>) -> Self {
        Self {
            d: self.d + self.rotation.rotate(by),
            rotation: self.rotation,
        }
    }
}

/// Which of the two rotation vectors of a rotation a map gives; see
/// [`log_quaternion`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LogBranch {
    /// That of the quaternion as it comes out.
    #[default]
    Same,
    /// That of its opposite.
    Opposite,
}

impl LogBranch {
    /// The rotation vector on this branch.
    pub fn log<S: Scalar>(self, turn: &Quaternion<S>) -> Vector3<S> {
        match self {
            Self::Same => log_quaternion(turn),
            Self::Opposite => log_quaternion(&turn.opposite()),
        }
    }
}

/// A coordinate that a joint releases.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Released {
    /// One number: its name, and what it measures.
    Coordinate(&'static str, Quantity),
    /// A rotation vector of its own, which changes its chart like that of a frame.
    Rotation,
}

impl Released {
    /// An unbounded angle of a name, in radians.
    pub const fn angle(name: &'static str) -> Self {
        Self::Coordinate(name, Quantity::Angle)
    }

    /// A length of a name.
    pub const fn displacement(name: &'static str) -> Self {
        Self::Coordinate(name, Quantity::Length)
    }

    /// A number of a name that is neither: the parameter of a curve, say.
    pub const fn parameter(name: &'static str) -> Self {
        Self::Coordinate(name, Quantity::Other)
    }

    /// What it is called, behind the joint's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Coordinate(name, _) => name,
            Self::Rotation => "rotation",
        }
    }

    /// How many of the joint's coordinates it is.
    pub fn dim(self) -> usize {
        match self {
            Self::Coordinate(..) => 1,
            Self::Rotation => 3,
        }
    }
}

/// A joint: the pose of the frame that is attached to it, as a function of D coordinates.
///
/// The coordinates are those of the joint's parents one after the other (six of a frame), then the
/// released ones.
pub trait Joint<const D: usize>: Send + Sync {
    /// The pose, written once over any [`Scalar`].
    fn pose<S: Scalar>(&self, t: S, q: &SVector<S, D>) -> Pose<S>;

    /// The coordinates that it releases, in the order in which they end `q`: all that are not of its
    /// parents, each with a name of its own.
    fn released(&self) -> &'static [Released] {
        const { &[] }
    }

    /// Distance of q to the edge of the joint's own domain; infinite by default. That the hung
    /// frame's rotation vector stays below 2π is seen to by [`JointMap`].
    fn margin(&self, t: f64, q: &SVector<f64, D>) -> f64 {
        let _ = (t, q);
        f64::INFINITY
    }

    /// What lies where the margin ends, and what to do about it: words that follow "the joint
    /// left".
    fn edge(&self) -> &'static str {
        CHART_EDGE
    }

    /// Keeps to the formula that holds at (t, q), or to none again, where the pose is pieced together
    /// from several: see [`Map::freeze_piece`]. Nothing to do by default.
    fn freeze_piece(&mut self, at: Option<(f64, &SVector<f64, D>)>) {
        let _ = at;
    }

    /// Whether the frame moves along when all parents move like one rigid body: true by default;
    /// false for a joint that is tied to space.
    fn is_objective(&self) -> bool {
        true
    }

    /// The kinematics in closed form, where there is a faster one than the derived one.
    fn kinematics(
        &self,
        branch: LogBranch,
        t: f64,
        q: &SVector<f64, D>,
        v: &SVector<f64, D>,
        a: &SVector<f64, D>,
    ) -> Option<Kinematics<D, 6>> {
        let _ = (branch, t, q, v, a);
        None
    }

    /// The geometric stiffness in closed form, where there is a faster one than the derived one.
    fn geometric_stiffness(
        &self,
        branch: LogBranch,
        t: f64,
        q: &SVector<f64, D>,
        f: &Vector6<f64>,
    ) -> Option<SMatrix<f64, D, D>> {
        let _ = (branch, t, q, f);
        None
    }
}

/// Whether a quaternion is a rotation, up to rounding.
fn is_unit(rotation: &Quaternion<f64>) -> bool {
    (rotation.dot(rotation) - 1.0).abs() < 1e-9
}

/// The map of a joint into a frame's six coordinates: its pose with the rotation's logarithm.
///
/// The logarithm stays on one branch during a step and changes at a converged state with ψ > π.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointMap<J> {
    joint: J,
    branch: LogBranch,
}

impl<J> JointMap<J> {
    /// The map of a joint.
    pub fn new(joint: J) -> Self {
        Self {
            joint,
            branch: LogBranch::default(),
        }
    }
}

impl<J, const D: usize> Map<D, 6> for JointMap<J>
where
    J: Joint<D>,
{
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, D>) -> SVector<S, 6> {
        let Pose { d, rotation: turn } = self.joint.pose(t, q);
        let psi = self.branch.log(&turn);
        SVector::<S, 6>::new(d.x, d.y, d.z, psi.x, psi.y, psi.z)
    }

    fn margin(&self, t: f64, q: &SVector<f64, D>) -> f64 {
        let own = self.joint.margin(t, q);
        if own.is_nan() || own <= 0.0 {
            return own;
        }
        let turn = self.joint.pose(t, q).rotation;
        if !is_unit(&turn) {
            return f64::NAN;
        }
        let w = match self.branch {
            LogBranch::Same => turn.w,
            LogBranch::Opposite => -turn.w,
        };
        // ψ = 2 atan2(|v|, w).
        own.min(TAU - 2.0 * turn.v.norm().atan2(w))
    }

    fn edge(&self) -> &'static str {
        self.joint.edge()
    }

    fn domain_error(&self, t: f64, q: &SVector<f64, D>) -> Option<String> {
        let rotation = self.joint.pose(t, q).rotation;
        let norm = rotation.dot(&rotation).sqrt();
        (norm.is_finite() && !is_unit(&rotation)).then(|| {
            format!("the quaternion of its pose has length {norm:.6}: make it a unit quaternion")
        })
    }

    fn is_objective(&self) -> bool {
        self.joint.is_objective()
    }

    fn freeze_piece(&mut self, at: Option<(f64, &SVector<f64, D>)>) {
        self.joint.freeze_piece(at);
    }

    fn change_charts(&mut self, t: f64, q: &SVector<f64, D>) -> ChartChanges {
        let best = if self.joint.pose(t, q).rotation.w < 0.0 {
            LogBranch::Opposite
        } else {
            LogBranch::Same
        };
        let changed = std::mem::replace(&mut self.branch, best) != best;
        ChartChanges {
            charts: usize::from(changed),
            residual: false,
        }
    }

    fn kinematics(
        &self,
        t: f64,
        q: &SVector<f64, D>,
        v: &SVector<f64, D>,
        a: &SVector<f64, D>,
    ) -> Kinematics<D, 6> {
        self.joint
            .kinematics(self.branch, t, q, v, a)
            .unwrap_or_else(|| derived::kinematics(self, t, q, v, a))
    }

    fn geometric_stiffness(
        &self,
        t: f64,
        q: &SVector<f64, D>,
        f: &Vector6<f64>,
    ) -> SMatrix<f64, D, D> {
        self.joint
            .geometric_stiffness(self.branch, t, q, f)
            .unwrap_or_else(|| derived::geometric_stiffness(self, t, q, f))
    }
}
