//! Scales of coordinates, and detection of residuals that are rounding errors.

use pullback_manifold::system::{CoordinateInfo, Quantity, System};

/// Largest residual per quantity in equilibrium. A quantity without loads and reactions must vanish
/// to rounding errors: the first residual would be a reference, but a stiff spring that is out of
/// balance makes it arbitrarily large. Gaps of multipliers contain no spring, so the gap after the
/// prediction is a fair reference. The limit is never smaller than `least`.
pub(crate) fn allowed(
    measures: [f64; 3],
    first: [f64; 3],
    relative: f64,
    least: [f64; 3],
) -> [f64; 3] {
    let allow = |k: usize| {
        let measure = match measures[k] > 0.0 {
            false if k == Quantity::Other.index() => first[k],
            _ => measures[k],
        };
        // The first residual has no digits below its own rounding.
        let rounding = f64::EPSILON * first[k];
        (relative * measure)
            .max(rounding)
            .max(least[k])
            .max(f64::MIN_POSITIVE)
    };
    std::array::from_fn(allow)
}

/// Rounding errors of a sum in units of those of its largest term; element forces add some ten.
const TERMS: f64 = 16.0;

/// 1 / typical size of each coordinate; zero for multipliers, which are tested by their residuals.
pub(crate) fn inverse_scales(system: &dyn System) -> Vec<f64> {
    let scales = system.scales().coordinate;
    let scale = |i: usize| match system.coordinate_info(i).is_multiplier {
        true => 0.0,
        false => 1.0 / scales[system.coordinate_info(i).quantity.index()],
    };
    (0..system.pattern().dim()).map(scale).collect()
}

/// Whether every residual is below the rounding errors of the coordinates,
/// `|r_i| ≤ 16 ε Σ_j |S_ij| |q_j|` (backward error: Oettli & Prager 1964, Numer. Math. 6).
///
/// All multipliers count as the largest: they are solved for together, and a vanishing one has the
/// rounding errors of the others. `sizes` and `floor` are scratch, one number per coordinate.
#[allow(non_snake_case)]
pub(crate) fn is_rounding(
    system: &dyn System,
    S: &[f64],
    q: &[f64],
    r: &[f64],
    [sizes, floor]: [&mut [f64]; 2],
) -> bool {
    let mut multipliers = (0..q.len())
        .filter(|&i| system.coordinate_info(i).is_multiplier)
        .peekable();
    let gaps = match multipliers.peek() {
        Some(_) => rounding_of_gaps(system, S, q, [&mut *sizes, &mut *floor]),
        None => 0.0,
    };
    let largest = multipliers.fold(0.0, |most, i| f64::max(most, q[i].abs()));
    let nothing = |_: usize| 0.0;
    find_rounding(
        system,
        S,
        q,
        (largest, &nothing),
        [&mut *sizes, &mut *floor],
    );
    let least = |i: usize| {
        if system.coordinate_info(i).is_multiplier {
            gaps
        } else {
            0.0
        }
    };
    (r.iter().zip(&*floor).enumerate())
        .all(|(i, (r, floor))| r.abs() <= TERMS * floor.max(least(i)))
}

/// The largest rounding error in the gaps of multipliers, ε Σ_j |S_ij| |q_j|, with coordinates not
/// below their scales: the gap after the prediction may be far below by chance, and at the origin
/// all of it is zero.
#[allow(non_snake_case)]
pub(crate) fn rounding_of_gaps(
    system: &dyn System,
    S: &[f64],
    q: &[f64],
    [sizes, floor]: [&mut [f64]; 2],
) -> f64 {
    let scales = system.scales().coordinate;
    let least = |i: usize| scales[system.coordinate_info(i).quantity.index()];
    find_rounding(system, S, q, (0.0, &least), [&mut *sizes, &mut *floor]);
    let gaps = (0..q.len()).filter(|&i| system.coordinate_info(i).is_multiplier);
    gaps.fold(0.0, |most, i| f64::max(most, floor[i]))
}

/// Writes the rounding error of each residual, ε Σ_j |S_ij| |q_j|, to `floor`; multipliers count as
/// `multiplier`.
///
/// Coordinates count with their [`CoordinateInfo::magnitude`], and at least with `least` of them: a small
/// displacement is the difference of positions that are not small.
#[allow(non_snake_case)]
fn find_rounding(
    system: &dyn System,
    S: &[f64],
    q: &[f64],
    (multiplier, least): (f64, &dyn Fn(usize) -> f64),
    [sizes, floor]: [&mut [f64]; 2],
) {
    for (i, (size, q)) in sizes.iter_mut().zip(q).enumerate() {
        *size = match system.coordinate_info(i).is_multiplier {
            true => multiplier,
            false => {
                let CoordinateInfo {
                    quantity,
                    magnitude,
                    ..
                } = system.coordinate_info(i);
                let scale = || system.scales().coordinate[quantity.index()];
                q.abs().max(magnitude.unwrap_or_else(scale)).max(least(i))
            }
        };
    }
    let pattern = system.pattern();
    floor.fill(0.0);
    for j in 0..pattern.blocks() {
        for (i, range) in pattern.column(j) {
            let rows = pattern.unknowns(i);
            let columns = S[range].chunks_exact(rows.len().max(1));
            for (column, size) in columns.zip(&sizes[pattern.unknowns(j)]) {
                for (floor, entry) in floor[rows.clone()].iter_mut().zip(column) {
                    *floor += f64::EPSILON * entry.abs() * size;
                }
            }
        }
    }
}
