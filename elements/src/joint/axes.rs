//! Directions of the axes of joints.

use nalgebra::Vector3;

/// Sine of the angle between two axes below which they count as parallel.
pub(super) const PARALLEL: f64 = 1e-6;

/// Error of the axes of a joint.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "each message says what its variant is")]
#[non_exhaustive]
pub enum AxisError {
    #[error("its axis {0:?} has no direction; give a finite vector that is not zero")]
    Direction([f64; 3]),
    #[error(
        "it starts at the centre or on the axis of its surface, where there is no radius; move one of the two"
    )]
    Radius,
    #[error("its two axes are parallel; give two directions")]
    Parallel,
    #[error(
        "its two axes are opposite: one shaft would be turned by 180° against the other, and in which \
         direction is not known; reverse one axis"
    )]
    Opposite,
}

/// The unit vector along an axis of any length; refused where it has no direction.
pub(super) fn direction(axis: [f64; 3]) -> Result<Vector3<f64>, AxisError> {
    let vector = Vector3::from(axis);
    let largest = vector.amax();
    if largest > 0.0 && axis.iter().all(|x| x.is_finite()) {
        Ok((vector / largest).normalize())
    } else {
        Err(AxisError::Direction(axis))
    }
}

/// A unit vector normal to `e`, and to the axis with the smallest component in `e`.
pub(super) fn across(e: &Vector3<f64>) -> Vector3<f64> {
    e.cross(&Vector3::ith(e.iamin(), 1.0)).normalize()
}
