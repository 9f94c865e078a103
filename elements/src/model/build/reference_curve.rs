//! Reference axes of beams: straight lines and arcs, with the orientation of the section.

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

/// A curve in space with an orientation of the cross-section: the reference shape of a line of beam
/// elements.
pub trait ReferenceCurve {
    /// Position and orientation at u ∈ [0, 1]. The columns of the matrix are E₁ (tangent), E₂, E₃ in
    /// global components.
    fn at(&self, u: f64) -> (Vector3<f64>, Matrix3<f64>);
}

/// Frame whose first axis is along `tangent` and whose second axis lies in the half-plane of the
/// tangent and `second`.
///
/// Without a usable `second` axis (`None`, or parallel to the tangent within 1e-6), E₃ is chosen
/// as close as possible to e3, or to e2 for a beam along e3.
pub fn frame_along(tangent: &Vector3<f64>, second: Option<&Vector3<f64>>) -> Matrix3<f64> {
    let e1 = tangent.normalize();
    let e3 = second
        .map(|s| e1.cross(s))
        .filter(|c| c.norm() > 1e-6 * second.map_or(1.0, Vector3::norm))
        .unwrap_or_else(|| {
            let up = if e1.z.abs() < 0.999 {
                Vector3::z()
            } else {
                Vector3::y()
            };
            up - e1 * up.dot(&e1)
        })
        .normalize();
    let e2 = e3.cross(&e1);
    Matrix3::from_columns(&[e1, e2, e3])
}

/// A straight axis, possibly with a pretwist.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightLine {
    /// Start.
    pub from: Vector3<f64>,
    /// End.
    pub to: Vector3<f64>,
    /// Direction of E₂ at the start (only its part normal to the axis counts).
    pub second: Option<Vector3<f64>>,
    /// Rotation of the section about the axis from start to end, in radians.
    pub twist: f64,
}

impl StraightLine {
    /// Without a pretwist; E₃ is as close as possible to e3, or to e2 for a line along e3.
    pub fn new(from: Vector3<f64>, to: Vector3<f64>) -> Self {
        Self {
            from,
            to,
            second: None,
            twist: 0.0,
        }
    }
}

impl ReferenceCurve for StraightLine {
    fn at(&self, u: f64) -> (Vector3<f64>, Matrix3<f64>) {
        let tangent = self.to - self.from;
        let frame = frame_along(&tangent, self.second.as_ref());
        let twist = Rotation3::from_axis_angle(&Vector3::x_axis(), self.twist * u);
        (self.from + tangent * u, frame * twist.matrix())
    }
}

/// A circular arc: starts at `from` and rotates by `angle` about the directed line through `center`
/// along `axis`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CircularArc {
    /// Start.
    pub from: Vector3<f64>,
    /// A point on the axis of rotation.
    pub center: Vector3<f64>,
    /// Direction of the axis of rotation.
    pub axis: Unit<Vector3<f64>>,
    /// Angle of the arc, in radians; positive about `axis` by the right-hand rule.
    pub angle: f64,
    /// Direction of E₂ at the start (only its part normal to the tangent counts).
    pub second: Option<Vector3<f64>>,
}

impl ReferenceCurve for CircularArc {
    fn at(&self, u: f64) -> (Vector3<f64>, Matrix3<f64>) {
        let radius = self.from - self.center;
        let tangent = self.axis.cross(&radius) * self.angle.signum();
        let start = frame_along(&tangent, self.second.as_ref());
        let turn = Rotation3::from_axis_angle(&self.axis, self.angle * u);
        (self.center + turn * radius, turn.matrix() * start)
    }
}
