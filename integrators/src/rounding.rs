//! When a residual is nothing but rounding errors.

use pullback_manifold::system::{Scales, System};

/// Rounding errors of a sum in units of those of its largest term; element forces add some ten.
const TERMS: f64 = 16.0;

/// Whether every residual is below what the rounding of the coordinates makes of it,
/// `|r_i| ≤ 16 ε Σ_j |S_ij| |q_j|` (backward error: Oettli & Prager 1964, Numer. Math. 6).
///
/// Coordinates count with the typical size of their kind at least: a small displacement is the
/// difference of places that are not. `sizes` and `floor` are room for a number per coordinate.
#[allow(non_snake_case)]
pub(crate) fn is_rounding<Y: System + ?Sized>(
    system: &Y,
    S: &[f64],
    q: &[f64],
    r: &[f64],
    [sizes, floor]: [&mut [f64]; 2],
) -> bool {
    let Scales { coordinate, .. } = system.scales();
    for (i, (size, q)) in sizes.iter_mut().zip(q).enumerate() {
        *size = q.abs();
        if !system.is_multiplier(i) {
            *size = size.max(coordinate[system.kind(i).index()]);
        }
    }
    let pattern = system.pattern();
    floor.fill(0.0);
    for j in 0..pattern.blocks() {
        for (i, range) in pattern.column(j) {
            let rows = pattern.unknowns(i);
            let columns = S[range].chunks_exact(rows.len().max(1));
            for (column, size) in columns.zip(&sizes[pattern.unknowns(j)]) {
                for (floor, entry) in floor[rows.clone()].iter_mut().zip(column) {
                    *floor += entry.abs() * size;
                }
            }
        }
    }
    (r.iter().zip(&*floor)).all(|(r, floor)| r.abs() <= TERMS * f64::EPSILON * floor)
}
