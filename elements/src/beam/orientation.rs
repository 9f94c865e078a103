//! Section axes along a reference line.

use super::element::BeamError;
use nalgebra::{Matrix3, Vector3};
use pullback_manifold::so3;

/// A given orientation with E₁ rotated to the unit tangent X′ by the smallest rotation.
///
/// # Errors
/// [`BeamError::Orientation`] for anything but a rotation with E₁ near the tangent.
pub fn oriented(given: &Matrix3<f64>, X_prime: &Vector3<f64>) -> Result<Matrix3<f64>, BeamError> {
    let first: Vector3<f64> = given.column(0).into_owned();
    let aligned = first.dot(X_prime);
    let skewed = (given.tr_mul(given) - Matrix3::identity()).amax();
    let rotation = skewed <= 1e-9 && given.determinant() > 0.0;
    if !rotation || aligned < 0.5 {
        return Err(BeamError::Orientation {
            tangent: (*X_prime).into(),
            first: first.into(),
        });
    }
    Ok(turn_to(&first, X_prime) * given)
}

/// The smallest rotation that takes unit vector `a` to unit vector `b` (a·b > 0).
fn turn_to(a: &Vector3<f64>, b: &Vector3<f64>) -> Matrix3<f64> {
    let v = so3::skew(&a.cross(b));
    Matrix3::identity() + v + v * v / (1.0 + a.dot(b))
}
