//! Scales of coordinates, and tests of residuals for equilibrium and for rounding errors.

use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::{CoordinateInfo, Quantity, System};

/// The test of a step's residuals for equilibrium, per quantity.
pub(crate) struct ResidualTest {
    relative: f64,
    absolute: f64,
    /// First nonzero residuals of the step; for a prediction, the change of the loads.
    pub first: [f64; 3],
    /// The largest rounding errors of the residuals.
    pub rounding: [f64; 3],
    /// Largest residuals in equilibrium, by the last test.
    pub allowed: [f64; 3],
}

impl ResidualTest {
    /// A test with a relative and an absolute tolerance.
    pub(crate) fn new(relative: f64, absolute: f64) -> Self {
        Self {
            relative,
            absolute,
            first: [0.0; 3],
            rounding: [0.0; 3],
            allowed: [0.0; 3],
        }
    }

    /// The largest residual relative to its tolerance.
    ///
    /// A quantity without loads and reactions must vanish to rounding errors: the first residual
    /// would be a reference, but a stiff spring that is out of balance makes it arbitrarily large.
    /// Gaps of multipliers contain no spring, so the gap after the prediction is a fair reference.
    /// Forces below the rounding errors of springs count as these: without loads, springs that yield
    /// to gaps of rounding errors make the only forces.
    pub(crate) fn ratio(&mut self, residual: [f64; 3], measures: [f64; 3]) -> f64 {
        for (first, most) in self.first.iter_mut().zip(residual) {
            if *first == 0.0 {
                *first = most;
            }
        }
        let allow = |k: usize| {
            let gaps = k == Quantity::Other.index();
            let (measure, least) = match gaps {
                true if measures[k] == 0.0 => (self.first[k], self.rounding[k]),
                true => (measures[k], self.rounding[k]),
                false => (measures[k].max(self.rounding[k]), 0.0),
            };
            // The first residual has no digits below its own rounding.
            let rounding = f64::EPSILON * self.first[k];
            (self.relative * measure)
                .max(rounding)
                .max(self.absolute)
                .max(least)
                .max(f64::MIN_POSITIVE)
        };
        self.allowed = std::array::from_fn(allow);
        let ratios = residual.iter().zip(self.allowed).map(|(r, a)| r / a);
        ratios.fold(0.0, f64::max)
    }
}

/// The largest entries per quantity of a residual vector, and of `others`.
pub(crate) fn largest(pattern: &BlockPattern, r: &[f64], others: [f64; 3]) -> [f64; 3] {
    let mut largest = others;
    for (r, info) in r.iter().zip(pattern.coordinates()) {
        let entry = &mut largest[info.quantity.index()];
        *entry = entry.max(r.abs());
    }
    largest
}

/// Largest residual of an equilibrium that counts as rounding, relative to loads and reactions.
pub(crate) const EXACT: f64 = 1e-12;

/// Whether residuals evaluated last are rounding errors of loads and reactions, and the gaps of multipliers those of positions and
/// angles.
pub(crate) fn is_exact(system: &dyn System, r: &[f64]) -> bool {
    let (scales, coordinates) = (system.scales(), system.pattern().coordinates());
    let measures = scales.measures();
    r.iter().zip(coordinates).all(|(r, info)| {
        let gap = match info.is_multiplier {
            true => scales.length.min(1.0),
            false => 0.0,
        };
        r.abs() <= EXACT * measures[info.quantity.index()].max(gap)
    })
}

/// Rounding errors of a sum in units of those of its largest term; element forces add some ten.
pub(crate) const TERMS: f64 = 16.0;

/// 1 / typical size of each coordinate; zero for multipliers, which are tested by their residuals.
pub(crate) fn inverse_scales(system: &dyn System) -> Vec<f64> {
    let scale = |info: &CoordinateInfo| match info.is_multiplier {
        true => 0.0,
        false => 1.0 / info.size,
    };
    system.pattern().coordinates().iter().map(scale).collect()
}

/// Whether every residual is below the rounding errors of the coordinates,
/// `|r_i| ≤ 16 ε Σ_j |S_ij| |q_j|` (backward error: Oettli & Prager 1964, Numer. Math. 6).
///
/// All multipliers count as the largest: they are solved for together, and a vanishing one has the
/// rounding errors of the others. `sizes` and `floor` are scratch, one number per coordinate.
pub(crate) fn is_rounding(
    system: &dyn System,
    S: &[f64],
    q: &[f64],
    r: &[f64],
    [sizes, floor]: [&mut [f64]; 2],
) -> bool {
    let is_multiplier = |i: usize| system.pattern().coordinates()[i].is_multiplier;
    let multipliers = (0..q.len()).filter(|&i| is_multiplier(i));
    let errors = rounding_errors(system, S, q, [&mut *sizes, &mut *floor]);
    let gaps = errors[Quantity::Other.index()];
    let largest = multipliers.fold(0.0, |most, i| f64::max(most, q[i].abs()));
    find_rounding(system, S, q, (largest, false), [sizes, &mut *floor]);
    (r.iter().zip(&*floor).enumerate()).all(|(i, (r, floor))| {
        let least = if is_multiplier(i) { gaps } else { 0.0 };
        r.abs() <= TERMS * floor.max(least)
    })
}

/// The largest rounding errors of residuals per quantity, ε Σ_j |S_ij| |q_j|, with coordinates not
/// below their scales and without multipliers: the gap after the prediction may be far below by
/// chance, and at the origin all of it is zero. Zero in a system without multipliers.
pub(crate) fn rounding_errors(
    system: &dyn System,
    S: &[f64],
    q: &[f64],
    [sizes, floor]: [&mut [f64]; 2],
) -> [f64; 3] {
    let mut coordinates = system.pattern().coordinates().iter();
    if !coordinates.any(|info| info.is_multiplier) {
        return [0.0; 3];
    }
    find_rounding(system, S, q, (0.0, true), [sizes, &mut *floor]);
    // Without other equations than those of multipliers.
    for (floor, info) in floor.iter_mut().zip(system.pattern().coordinates()) {
        if info.quantity == Quantity::Other && !info.is_multiplier {
            *floor = 0.0;
        }
    }
    largest(system.pattern(), floor, [0.0; 3])
}

/// Writes the rounding error of each residual, ε Σ_j |S_ij| |q_j|, to `floor`; multipliers count as
/// `multiplier`.
///
/// Coordinates count with their [`CoordinateInfo::magnitude`], and if `scaled` at least with their
/// scale: a small displacement is the difference of positions that are not small.
fn find_rounding(
    system: &dyn System,
    S: &[f64],
    q: &[f64],
    (multiplier, scaled): (f64, bool),
    [sizes, floor]: [&mut [f64]; 2],
) {
    let pattern = system.pattern();
    for ((size, q), info) in sizes.iter_mut().zip(q).zip(pattern.coordinates()) {
        let least = if scaled { info.size } else { 0.0 };
        *size = match info.is_multiplier {
            true => multiplier,
            false => q.abs().max(info.magnitude.unwrap_or(info.size)).max(least),
        };
    }
    floor.fill(0.0);
    // By blocks: entry by entry is slower in large models.
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
