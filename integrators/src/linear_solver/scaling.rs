//! Symmetric scaling by powers of two.
//!
//! Rows of forces and rows of moments, stretching and bending differ by many orders of magnitude,
//! and a pivot can only be called small against something. `S A S` with `s_i ≈ 1/√|A_ii|` is
//! dimensionless and, for a positive definite matrix, within a factor of the best conditioned
//! scaling there is; powers of two make it free of rounding, so that it changes no digit of the
//! elimination.

use pullback_manifold::sparse::BlockPattern;

use super::LinearError;

/// Scaled entries of a block may be this large in the mean square before the diagonal is declared
/// unfit as a scale (a zero on the diagonal of a saddle point matrix, say).
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

/// Sweeps of an equilibration at most.
const SWEEPS: usize = 8;

/// Where equilibration begins: rows by their diagonal, and those without one by what couples them to
/// rows that have a scale.
///
/// A saddle point matrix [A Gᵀ; G 0] with Gᵀ far larger than A is equilibrated as it stands, but then
/// A, which alone resists along the null space of G, is below rounding. From here both come to
/// one, whatever the units of the unknowns: another unit divides the scale of a row, here and in all
/// sweeps.
///
/// A diagonal that is nothing but rounding errors makes one entry of a row of G stand out by
/// [`OUTLIER`]: it is not believed, and its row takes its scale from G, too.
fn begin(
    pattern: &BlockPattern,
    values: &[f64],
    scales: &mut [f64],
    [largest, second]: [&mut [f64]; 2],
) {
    for j in 0..pattern.blocks() {
        for (c, s) in scales[pattern.unknowns(j)].iter_mut().enumerate() {
            let start = pattern.find(j, j);
            let scale = start.map(|k| inverse_root(values[k + c * (pattern.size(j) + 1)]));
            *s = scale.filter(|s| s.is_finite()).unwrap_or(0.0);
        }
    }
    // Multipliers hang on coordinates, and coordinates without any stiffness on multipliers.
    for _ in 0..PASSES {
        largest.fill(0.0);
        second.fill(0.0);
        for_each(pattern, values, |r, c, value| {
            let entry = (value * scales[c]).abs();
            if entry > largest[r] {
                second[r] = largest[r];
                largest[r] = entry;
            } else if entry > second[r] {
                second[r] = entry;
            }
        });
        let mut done = true;
        for ((s, largest), second) in scales.iter_mut().zip(&*largest).zip(&*second) {
            let stands_out = *second > 0.0 && *largest > OUTLIER * second;
            let root = inverse_root(if stands_out { *second } else { *largest });
            if *s == 0.0 && root.is_finite() {
                // The sign marks rows without a diagonal until all are found.
                *s = -root * root;
                done = false;
            }
        }
        if done {
            break;
        }
    }
    largest.fill(0.0);
    for_each(pattern, values, |r, c, value| {
        if scales[r] > 0.0 && scales[c] < 0.0 {
            largest[r] = largest[r].max((value * scales[c]).abs());
        }
    });
    for (s, m) in scales.iter_mut().zip(&*largest) {
        let root = inverse_root(*m);
        if root.is_finite() && *s > OUTLIER.sqrt() * root * root {
            *s = root * root;
        }
        *s = if *s == 0.0 { 1.0 } else { s.abs() };
    }
}

/// Calls with row, column and value of each entry.
fn for_each(pattern: &BlockPattern, values: &[f64], mut with: impl FnMut(usize, usize, f64)) {
    for j in 0..pattern.blocks() {
        for (i, range) in pattern.column(j) {
            let height = pattern.size(i).max(1);
            for (column, c) in values[range].chunks_exact(height).zip(pattern.unknowns(j)) {
                for (value, r) in column.iter().zip(pattern.unknowns(i)) {
                    with(r, c, *value);
                }
            }
        }
    }
}

/// Rows without a diagonal between one and the next row that has one, at most.
const PASSES: usize = 4;

/// An entry this much larger than all others of its row comes from a diagonal that is no scale.
const OUTLIER: f64 = 1e3;

/// Scales by equilibration, for matrices whose diagonal is no measure of their rows.
///
/// They begin with rows by their diagonal. Sweeps of `s_i ← s_i / √(max_j |s_i A_ij s_j|)` [Ruiz 2001], which treats rows and columns alike
/// and needs no diagonal. Each halves the range of the rows in logarithms: eight of them take
/// masses over a squared step of 10⁻⁸ and gradients of equations to the same size.
///
/// # Errors
/// Values that are not finite, and rows that are zero.
pub fn equilibrate(
    pattern: &BlockPattern,
    values: &[f64],
    scales: &mut [f64],
    [largest, second]: [&mut [f64]; 2],
) -> Result<(), LinearError> {
    begin(pattern, values, scales, [largest, second]);
    for sweep in 0..SWEEPS {
        largest.fill(0.0);
        for j in 0..pattern.blocks() {
            for (i, range) in pattern.column(j) {
                let height = pattern.size(i).max(1);
                for (column, c) in values[range].chunks_exact(height).zip(pattern.unknowns(j)) {
                    for (value, r) in column.iter().zip(pattern.unknowns(i)) {
                        let scaled = (value * scales[r] * scales[c]).abs();
                        if !value.is_finite() {
                            return Err(LinearError::NonFinite {
                                what: "matrix",
                                unknown: r,
                            });
                        }
                        largest[r] = largest[r].max(scaled);
                        largest[c] = largest[c].max(scaled);
                    }
                }
            }
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
            done &= factor == 1.0;
            *s *= factor;
        }
        if done {
            break;
        }
    }
    Ok(())
}

/// Scales of a matrix: from its diagonal if that is a fair measure, else by equilibration.
///
/// # Errors
/// See [`equilibrate`].
pub(crate) fn scales(
    pattern: &BlockPattern,
    values: &[f64],
    scales: &mut [f64],
    work: [&mut [f64]; 2],
) -> Result<(), LinearError> {
    for j in 0..pattern.blocks() {
        let Some(start) = pattern.find(j, j) else {
            continue;
        };
        let n = pattern.size(j);
        for (c, s) in scales[pattern.unknowns(j)].iter_mut().enumerate() {
            *s = inverse_root(values[start + c * (n + 1)]);
        }
    }
    for j in 0..pattern.blocks() {
        for (i, range) in pattern.column(j) {
            let height = pattern.size(i).max(1);
            let mut sum = 0.0;
            for (column, c) in values[range.clone()]
                .chunks_exact(height)
                .zip(pattern.unknowns(j))
            {
                for (value, r) in column.iter().zip(pattern.unknowns(i)) {
                    let scaled = value * scales[r] * scales[c];
                    sum += scaled * scaled;
                }
            }
            // Written so that NaN fails, too.
            if !(sum <= MEAN_SQUARE_LIMIT * range.len() as f64) {
                return equilibrate(pattern, values, scales, work);
            }
        }
    }
    Ok(())
}

/// Bound on the spectral norm of the scaled matrix: block columns of Frobenius norms.
pub(crate) fn norm(pattern: &BlockPattern, values: &[f64], scales: &[f64]) -> f64 {
    let mut largest = 0.0_f64;
    for j in 0..pattern.blocks() {
        let (mut sum, mut blocks) = (0.0, 0.0);
        for (i, range) in pattern.column(j) {
            let height = pattern.size(i).max(1);
            for (column, c) in values[range].chunks_exact(height).zip(pattern.unknowns(j)) {
                for (value, r) in column.iter().zip(pattern.unknowns(i)) {
                    let scaled = value * scales[r] * scales[c];
                    sum += scaled * scaled;
                }
            }
            blocks += 1.0;
        }
        largest = largest.max(sum * blocks);
    }
    largest.sqrt()
}
