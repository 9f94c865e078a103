//! Symmetric scaling by powers of two.
//!
//! Rows of forces and rows of moments, stretching and bending differ by many orders of magnitude, and a
//! pivot can only be called small against something. `S A S` with `s_i ≈ 1/√|A_ii|` is dimensionless
//! and, for a positive definite matrix, within a factor of the best conditioned scaling there is;
//! powers of two make it free of rounding, so that it changes no digit of the elimination.

use pullback_manifold::sparse::BlockPattern;

use super::LinearError;

/// Largest mean square of the scaled entries of a block at which the diagonal is a valid scale (it
/// is not with a zero on the diagonal of a saddle point matrix, for example).
pub(crate) const MEAN_SQUARE_LIMIT: f64 = 64.0;

/// A power of two near `1/√|d|`; infinite for a zero or subnormal `d`.
#[inline(always)]
pub(crate) fn inverse_root(d: f64) -> f64 {
    let exponent = ((d.to_bits() >> 52) & 0x7ff) as i64;
    if exponent == 0 {
        return f64::INFINITY;
    }
    let half = (exponent - 1023) >> 1;
    f64::from_bits(((1023 - half) as u64) << 52)
}

/// Largest number of sweeps of an equilibration.
const SWEEPS: usize = 8;

/// Diagonals below this part of the largest, in typical sizes of the unknowns, are not valid scales:
/// half of the digits may be rounding errors of stiffer parts, half are left for the elimination.
const FLOOR: f64 = 1.5e-8;

/// Diagonals below this part of the largest are rounding errors, as that of an angle on which only multipliers act.
const NOTHING: f64 = 1e-12;

/// Initial scales: rows by their diagonal, those of multipliers by what they couple.
///
/// A saddle point matrix [A Gᵀ; G 0] is in equilibrium with entries of G that are far larger than A,
/// too; but then A, which alone resists along the null space of G, is below rounding. From here both
/// are of order one, as A and the Schur complement G A⁻¹ Gᵀ are when scaled by their diagonals,
/// whatever the units: another unit of an unknown divides its scale, here and in all sweeps. What has
/// no stiffness is scaled as the stiffest: by the floor, its part of G would be the only one above rounding.
fn begin(pattern: &BlockPattern, values: &[f64], scales: &mut [f64], largest: &mut [f64]) {
    let coordinates = pattern.coordinates();
    let mut most = 0.0;
    pattern.triplets(values).for_each(|(r, c, value)| {
        if r == c {
            scales[r] = value.abs();
            if !coordinates[r].is_multiplier {
                let size = coordinates[r].size;
                most = f64::max(most, value.abs() * size * size);
            }
        }
    });
    let most = if most > 0.0 { most } else { 1.0 };
    for (s, c) in scales.iter_mut().zip(coordinates) {
        let stiffest = most / (c.size * c.size);
        let scale = match c.is_multiplier {
            true => *s,
            false if *s <= NOTHING * stiffest => stiffest,
            false => s.max(FLOOR * stiffest),
        };
        *s = inverse_root(scale).min(f64::MAX);
    }
    largest.fill(0.0);
    pattern.triplets(values).for_each(|(r, c, value)| {
        if coordinates[r].is_multiplier && !coordinates[c].is_multiplier {
            largest[r] = f64::max(largest[r], (value * scales[c]).abs());
        }
    });
    for (s, m) in scales.iter_mut().zip(largest) {
        let root = inverse_root(*m);
        if root.is_finite() {
            *s = root * root;
        }
    }
}

/// Scales by equilibration, for matrices whose diagonal is not a valid scale.
///
/// Sweeps of `s_i ← s_i / √(max_j |s_i A_ij s_j|)` [Ruiz 2001], which treat rows and columns alike
/// and need no diagonal. They begin with the diagonal if it is valid, in the typical sizes of the
/// unknowns ([`BlockPattern::coordinates`]); each halves the remaining range of the rows in logarithms.
///
/// # Errors
/// Values that are not finite, and rows that are zero.
pub fn equilibrate(
    pattern: &BlockPattern,
    values: &[f64],
    scales: &mut [f64],
    largest: &mut [f64],
) -> Result<(), LinearError> {
    begin(pattern, values, scales, largest);
    for sweep in 0..SWEEPS {
        largest.fill(0.0);
        let mut bad = None;
        pattern.triplets(values).for_each(|(r, c, value)| {
            if !value.is_finite() {
                bad = bad.or(Some(r));
            }
            let scaled = (value * scales[r] * scales[c]).abs();
            largest[r] = largest[r].max(scaled);
            largest[c] = largest[c].max(scaled);
        });
        if let Some(unknown) = bad {
            return Err(LinearError::NonFinite {
                what: "matrix",
                unknown,
            });
        }
        let mut done = true;
        for (unknown, (s, &m)) in scales.iter_mut().zip(&*largest).enumerate() {
            let factor = inverse_root(m);
            if !factor.is_finite() {
                if sweep == 0 {
                    return Err(LinearError::ZeroRow { unknown });
                }
                continue;
            }
            // More accuracy is of no use.
            done &= (0.5..=2.0).contains(&factor);
            *s *= factor;
        }
        if done {
            break;
        }
    }
    Ok(())
}

/// Scales of a matrix: from its diagonal if that is valid, else by equilibration.
///
/// # Errors
/// See [`equilibrate`].
pub(crate) fn scales(
    pattern: &BlockPattern,
    values: &[f64],
    scales: &mut [f64],
    work: &mut [f64],
) -> Result<(), LinearError> {
    for (s, k) in scales.iter_mut().zip(pattern.diagonal()) {
        *s = inverse_root(values[k]);
    }
    for j in 0..pattern.blocks() {
        for (i, range) in pattern.column(j) {
            let sum = square_of_block(pattern, [i, j], &values[range.clone()], scales);
            // NaN fails, too.
            if !(sum <= MEAN_SQUARE_LIMIT * range.len() as f64) {
                return equilibrate(pattern, values, scales, work);
            }
        }
    }
    Ok(())
}

/// Sum of the squares of the scaled entries of a block.
fn square_of_block(
    pattern: &BlockPattern,
    [i, j]: [usize; 2],
    block: &[f64],
    scales: &[f64],
) -> f64 {
    let (rows, columns) = (&scales[pattern.unknowns(i)], &scales[pattern.unknowns(j)]);
    let entries = block.chunks_exact(rows.len().max(1));
    let squares = entries.zip(columns).map(|(column, c)| -> f64 {
        let scaled = column.iter().zip(rows);
        scaled.map(|(a, r)| (a * r * c).powi(2)).sum()
    });
    squares.sum()
}

/// Bound on the spectral norm of the scaled matrix: block columns of Frobenius norms.
pub(crate) fn norm(pattern: &BlockPattern, values: &[f64], scales: &[f64]) -> f64 {
    let mut largest = 0.0_f64;
    for j in 0..pattern.blocks() {
        let (mut sum, mut blocks) = (0.0, 0.0);
        for (i, range) in pattern.column(j) {
            sum += square_of_block(pattern, [i, j], &values[range], scales);
            blocks += 1.0;
        }
        largest = largest.max(sum * blocks);
    }
    largest.sqrt()
}
