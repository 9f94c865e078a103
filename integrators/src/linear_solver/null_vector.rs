//! The mechanism of a singular structure.

use pullback_manifold::sparse::BlockPattern;

use super::columns::Columns;
use super::faer::Factors;
use super::{FaerLu, LinearError, max_abs};
use crate::vectors::generic;

/// A direction that the matrix (nearly) annihilates.
#[derive(Clone, Debug, PartialEq)]
pub struct NullVector {
    /// The direction, its largest component ±1 (the first of them +1).
    pub vector: Vec<f64>,
    /// max|A v| / (‖A‖ max|v|) of the scaled matrix.
    pub residual: f64,
}

/// Directions with a larger residual are not mechanisms.
const LIMIT: f64 = 1e-11;
const ITERATIONS: usize = 6;

/// Direction of the mechanism of a (nearly) singular matrix; `None` for a regular one.
///
/// Inverse iteration in the scaled matrix with a small shift of its diagonal. Of several mechanisms any combination may
/// be found.
pub fn null_vector(pattern: &BlockPattern, values: &[f64]) -> Option<NullVector> {
    if values.len() != pattern.len() || pattern.dim() == 0 {
        return None;
    }
    let mut lu = FaerLu::new(pattern).ok()?;
    match lu.shifted(values) {
        Ok((columns, factors)) => {
            iterate(columns, values, |y| factors.solve(y)).filter(|v| v.residual <= LIMIT)
        }
        // A zero row and column is a mechanism by itself.
        Err(LinearError::ZeroRow { unknown }) => {
            let mut vector = vec![0.0; pattern.dim()];
            vector[unknown] = 1.0;
            let residual = 0.0;
            Some(NullVector { vector, residual })
        }
        Err(_) => None,
    }
}

/// Best direction of a few inverse iterations in the scaled matrix.
fn iterate(
    columns: &Columns,
    values: &[f64],
    mut inverse: impl FnMut(&mut [f64]),
) -> Option<NullVector> {
    let scales = &columns.scales;
    // The iterate is the vector `y` of the scaled matrix: v = S y, A v = S⁻¹ (S A S) y.
    let mut y = generic(scales.len());
    let mut best: Option<NullVector> = None;
    for _ in 0..ITERATIONS {
        inverse(&mut y);
        let size = max_abs(&y);
        if !(size > 0.0 && size <= f64::MAX) {
            break;
        }
        y.iter_mut().for_each(|y| *y /= size);
        let mut image = vec![0.0; y.len()];
        let mut v: Vec<f64> = y.iter().zip(scales).map(|(y, s)| y * s).collect();
        columns.pattern.multiply_add(1.0, values, &v, &mut image);
        image.iter_mut().zip(scales).for_each(|(a, s)| *a *= s);
        let residual = max_abs(&image) / columns.norm;
        if best.as_ref().is_some_and(|b| residual >= b.residual) {
            break;
        }
        let largest = max_abs(&v);
        let sign = v
            .iter()
            .find(|x| x.abs() == largest)
            .map_or(1.0, |x| x.signum());
        v.iter_mut().for_each(|v| *v /= sign * largest);
        best = Some(NullVector {
            vector: v,
            residual,
        });
    }
    best
}
