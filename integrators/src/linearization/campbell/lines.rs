//! Lines of a Campbell diagram: modes of successive speeds whose shapes agree best.

use super::{Linearized, Mode, inner_product};
use num_complex::Complex64;

/// Least agreement of shapes that are one line.
const SAME: f64 = 0.2;
/// Distance of eigenvalues that count as repeated, relative to their size.
const REPEATED: f64 = 1e-6;
/// Ratio of the stiffness of a shape of unit mass to the largest |λ|², above which its mass is a rounding error.
const MASSLESS: f64 = 1e6;

impl Linearized {
    /// Removes shapes without mass, but for rounding errors, in which dampers alone relax: they are orthogonal to nothing.
    pub(super) fn retain_vibrations(&self, modes: &mut Vec<Mode>) {
        let fastest = modes.iter().map(Mode::omega).fold(0.0, f64::max);
        modes.retain(|mode| {
            let form =
                |values: &[f64]| inner_product(&mode.shape, &self.product(values, &mode.shape)).re;
            let (stiffness, mass) = (form(&self.K), form(&self.M));
            // A shape with mass is one of unit mass.
            mass > 0.5 && (fastest == 0.0 || stiffness.abs() <= MASSLESS * fastest * fastest)
        });
    }
}

/// Lines at a speed.
#[derive(Default)]
pub(super) struct Lines {
    /// Their modes, each the one of its conjugate pair that continues its line.
    pub modes: Vec<Option<Mode>>,
    /// For each line the first one of those with which it has always had one eigenvalue: their shapes are any ones in a space.
    families: Vec<usize>,
}

impl Lines {
    /// The lines with their modes at the next speed, and new ones behind them.
    pub(super) fn next(&self, modes: Vec<Option<Mode>>) -> Self {
        let before = |i: usize| self.families.get(i).copied().unwrap_or(usize::MAX);
        let first = |i: usize| {
            let mut earlier = (0..i).filter(|&k| before(k) == before(i));
            let alike =
                |k: &usize| matches!((&modes[i], &modes[*k]), (Some(a), Some(b)) if same(a, b));
            earlier.find(alike).unwrap_or(i)
        };
        let families = (0..modes.len()).map(first).collect();
        Self { modes, families }
    }
}

/// Continues lines by modes at the next speed; with the least agreement of shapes. For each line that ends here, the lowest mode
/// that has none begins one. Where lines meet, each keeps the part of its shape in their space.
pub(super) fn continued(lines: &Lines, found: Vec<Mode>, lin: &Linearized) -> (Lines, f64) {
    let own: Vec<usize> = (0..lines.modes.len())
        .filter(|&i| lines.modes[i].is_some())
        .collect();
    let before: Vec<Mode> = lines.modes.iter().flatten().cloned().collect();
    let pairs = (0..found.len()).filter(|&j| found[j].eigenvalue.im != 0.0);
    let of: Vec<usize> = (0..found.len()).chain(pairs).collect();
    let conjugates: Vec<Mode> = of[found.len()..]
        .iter()
        .map(|&j| conjugate(&found[j]))
        .collect();
    let found = [found, conjugates].concat();
    // Shapes of repeated eigenvalues are any ones in their space.
    let groups = groups(&found);
    let mac = assurance(&before, &found, lin);
    let family = |i: usize| lines.families[own[i]];
    let relatives = |i: usize| (0..own.len()).filter(move |&k| family(k) == family(i));
    let agreement = |i: usize, j: usize| -> f64 {
        let row = |k: usize| groups[j].iter().map(|&l| mac[k][l]).sum::<f64>();
        let sum: f64 = relatives(i).map(row).sum();
        sum / relatives(i).count().min(groups[j].len()) as f64
    };
    let mut matches: Vec<(f64, usize, usize)> = (0..before.len())
        .flat_map(|i| (0..found.len()).map(move |j| (i, j)))
        .map(|(i, j)| (agreement(i, j), i, j))
        .collect();
    matches.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut out: Vec<Option<Mode>> = vec![None; lines.modes.len()];
    let (mut taken, mut least) = (vec![false; found.len()], 1.0_f64);
    let mut open = vec![true; before.len()];
    for &(agreement, i, mut j) in &matches {
        if agreement >= SAME && open[i] && !taken[of[j]] {
            // Where a pair becomes two real eigenvalues, λ and about −λ, the line is the one that grows.
            if before[i].eigenvalue.im != 0.0 && found[j].eigenvalue.im == 0.0 {
                let real = |&&(other, row, k): &&(f64, usize, usize)| {
                    let similar = row == i && other >= 0.5 * agreement && !taken[of[k]];
                    similar && found[k].eigenvalue.im == 0.0
                };
                let growth = |&(.., k): &(f64, usize, usize)| found[k].eigenvalue.re;
                let split = matches.iter().filter(real);
                let most = split.max_by(|a, b| growth(a).total_cmp(&growth(b)));
                j = most.map_or(j, |&(.., k)| k);
            }
            (open[i], taken[of[j]]) = (false, true);
            least = least.min(agreement);
            let space = groups[j].iter().map(|&l| &found[l]);
            out[own[i]] = Some(part(&before[i], &found[j], space, lin));
        }
    }
    let ended = open.iter().filter(|open| **open).count();
    let others = (0..found.len()).filter(|&j| of[j] == j && !taken[j]);
    out.extend(others.take(ended).map(|j| Some(found[j].clone())));
    (lines.next(out), if ended > 0 { 0.0 } else { least })
}

/// A mode with the part that a shape before has in the space of its repeated eigenvalue, if that is large enough.
fn part<'a>(
    before: &Mode,
    mode: &Mode,
    space: impl ExactSizeIterator<Item = &'a Mode>,
    lin: &Linearized,
) -> Mode {
    let (mut part, mut square) = (mode.clone(), 0.0);
    if space.len() < 2 {
        return part;
    }
    part.shape.fill(Complex64::ZERO);
    let image = lin.product(&lin.M, &before.shape);
    for Mode { shape, .. } in space {
        let along = inner_product(shape, &image);
        square += along.norm_sqr();
        (part.shape.iter_mut().zip(shape)).for_each(|(x, y)| *x += along * y);
    }
    part.shape.iter_mut().for_each(|x| *x /= square.sqrt());
    if square < SAME { mode.clone() } else { part }
}

/// The other mode of a pair of conjugates.
pub(super) fn conjugate(mode: &Mode) -> Mode {
    Mode {
        eigenvalue: mode.eigenvalue.conj(),
        shape: mode.shape.iter().map(|x| x.conj()).collect(),
        ..*mode
    }
}

/// The modal assurance criterion of each mode with each of others, shapes of unit mass with their velocities.
fn assurance(before: &[Mode], found: &[Mode], lin: &Linearized) -> Vec<Vec<f64>> {
    let omega = before.iter().map(Mode::omega).fold(0.0, f64::max);
    // (s² + λ̄ μ)² over the squares of the lengths; of rigid modes alone, one.
    let velocities = |a: &Mode, b: &Mode| {
        let square = |mode: &Mode| omega * omega + mode.eigenvalue.norm_sqr();
        let product = omega * omega + a.eigenvalue.conj() * b.eigenvalue;
        match square(a) * square(b) {
            0.0 => 1.0,
            squares => product.norm_sqr() / squares,
        }
    };
    let agreements = |mode: &Mode| -> Vec<f64> {
        let image = lin.product(&lin.M, &mode.shape);
        let shapes = |other: &Mode| inner_product(&other.shape, &image).norm_sqr();
        let found = found.iter();
        found
            .map(|other| shapes(other) * velocities(other, mode))
            .collect()
    };
    before.iter().map(agreements).collect()
}

/// Whether two modes have one eigenvalue.
fn same(a: &Mode, b: &Mode) -> bool {
    let (a, b) = (a.eigenvalue, b.eigenvalue);
    (a - b).norm() <= REPEATED * a.norm().max(b.norm())
}

/// For each mode all modes with the same eigenvalue.
pub(super) fn groups(modes: &[Mode]) -> Vec<Vec<usize>> {
    let all = |i: usize| {
        (0..modes.len())
            .filter(|&j| same(&modes[i], &modes[j]))
            .collect()
    };
    (0..modes.len()).map(all).collect()
}
