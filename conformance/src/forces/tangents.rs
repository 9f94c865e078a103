//! K = −∂r/∂x, C = −∂r/∂ẋ and M = −∂r/∂ẍ, group by group of coordinates.

use super::{Laws, TestState};
use crate::block::{Column, Rows, difference, wrong_blocks};
use crate::layout::{CoordinateGroup, Layout};
use crate::report::Measure;
use crate::vectors::minus;
use nalgebra::DVector;
use pullback_manifold::sparse::BlockPattern;

/// One of the three tangents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    K,
    C,
    M,
}

impl Part {
    const ALL: [Self; 3] = [Self::K, Self::C, Self::M];

    fn law(self) -> &'static str {
        ["K = -dr/dx", "C = -dr/dv", "M = -dr/da"][self as usize]
    }

    fn name(self) -> &'static str {
        ["K", "C", "M"][self as usize]
    }

    /// The vector of a state with respect to which it is the derivative.
    fn of(self, s: &mut TestState) -> &mut DVector<f64> {
        match self {
            Self::K => &mut s.x,
            Self::C => &mut s.v,
            Self::M => &mut s.a,
        }
    }
}

/// A residual and its three tangents at one state.
pub(crate) struct Linearization<'a> {
    pub pattern: &'a BlockPattern,
    pub r: &'a [f64],
    /// Values of K, C and M in the pattern.
    pub values: [Vec<f64>; 3],
}

/// The residual at a state, if that is inside the domain.
pub(crate) type Residual<'a> = dyn FnMut(&TestState) -> Option<Vec<f64>> + 'a;

/// First step along coordinates, in units: half of the change at which a rotation leaves the domain of its chart.
pub(crate) const FIRST: f64 = 0.05;
/// Least defect by differences, over the magnitude of the terms, that confirms a slope that is too small: their own
/// errors are below it.
pub(crate) const CONFIRMED: f64 = 1e-9;
/// Step of these differences in units.
pub(crate) const STEP: f64 = 1e-3;

impl Linearization<'_> {
    fn times(&self, part: Part, d: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.r.len()];
        let values = &self.values[part as usize];
        self.pattern.multiply_add(1.0, values, d, &mut out);
        out
    }

    /// Sum over each row of the magnitudes of its entries, times those of a vector.
    fn magnitude(&self, part: Part, d: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.r.len()];
        let absolute: Vec<f64> = self.values[part as usize].iter().map(|x| x.abs()).collect();
        self.pattern.multiply_add(1.0, &absolute, d, &mut out);
        out
    }

    /// The magnitude of the terms of the residual in each group, as an energy.
    pub(crate) fn sizes(&self, layout: &Layout, s: &TestState) -> Vec<f64> {
        let mut all: Vec<f64> = self.r.iter().map(|r| r.abs()).collect();
        for (part, x) in Part::ALL.into_iter().zip([&s.x, &s.v, &s.a]) {
            if !x.is_empty() {
                let magnitudes = layout.magnitudes(x.as_slice(), part as i32);
                let more = self.magnitude(part, &magnitudes);
                all.iter_mut().zip(more).for_each(|(a, m)| *a += m);
            }
        }
        let mut of_unknowns = vec![0.0; all.len()];
        let sizes = layout.forces(&all);
        for (group, size) in layout.groups().iter().zip(&sizes) {
            of_unknowns[group.range.clone()].fill(*size);
        }
        self.raise(&mut of_unknowns);
        let first = |g: &CoordinateGroup| of_unknowns.get(g.range.start).copied();
        let sizes = layout.groups().iter().zip(sizes);
        sizes.map(|(g, size)| first(g).unwrap_or(size)).collect()
    }

    /// Raises the energies of unknowns to [`MIXED`] of the largest of those coupled to them: a map that mixes
    /// coordinates adds terms of that size, which may cancel.
    fn raise(&self, energies: &mut [f64]) {
        let pattern = self.pattern;
        let most = |b: usize| {
            let own = pattern.unknowns(b).map(|u| energies[u]);
            own.fold(0.0, f64::max)
        };
        let own: Vec<f64> = (0..pattern.blocks()).map(most).collect();
        let mut near = own.clone();
        for (j, own) in own.iter().enumerate() {
            for (i, _) in pattern.column(j) {
                near[i] = near[i].max(*own);
            }
        }
        for (b, near) in near.iter().enumerate() {
            for energy in &mut energies[pattern.unknowns(b)] {
                if *energy < MIXED * near {
                    *energy = MIXED * near;
                }
            }
        }
    }

    /// Checks the symmetry of a tangent up to the `noise` of its values in the pattern, which may be empty.
    pub(crate) fn symmetric(&self, laws: &mut Laws<'_>, part: Part, noise: &[f64]) {
        let values = &self.values[part as usize];
        let units = laws.layout.units();
        let ones: Vec<f64> = units.iter().map(|u| 1.0 / u).collect();
        let mut rows = self.magnitude(part, &units);
        rows.iter_mut().zip(&ones).for_each(|(r, one)| *r /= one);
        self.raise(&mut rows);
        let mut worst = (0.0, 0.0, 1.0);
        let mut entries = Vec::new();
        for j in 0..self.pattern.blocks() {
            for (i, range) in self.pattern.column(j) {
                let Some(mirror) = self.pattern.find(j, i) else {
                    continue;
                };
                let (rows_i, rows_j) = (self.pattern.unknowns(i), self.pattern.unknowns(j));
                for (c, J) in rows_j.clone().enumerate() {
                    for (r, I) in rows_i.clone().enumerate() {
                        let at = [
                            range.start + r + c * rows_i.len(),
                            mirror + c + r * rows_j.len(),
                        ];
                        let [a, b] = at.map(|k| values[k]);
                        let lost: f64 = at.iter().filter_map(|k| noise.get(*k)).sum();
                        let unit = units[I] * units[J];
                        let gap = (a - b).abs() * unit;
                        let allowed = SYMMETRIC * (rows[I] * rows[J]).sqrt() + lost * unit;
                        let strain = if gap == 0.0 { 0.0 } else { gap / allowed };
                        if strain > 1.0 || strain.is_nan() {
                            entries.push((I, J, a, b));
                        }
                        if strain >= worst.0 || strain.is_nan() {
                            worst = (strain, gap, allowed);
                        }
                    }
                }
            }
        }
        let law = format!("{} symmetric", part.name());
        laws.report.defect(&law, laws.at, worst.1, worst.2);
        laws.report.blame(|| {
            let mut columns: Vec<Column> = Vec::new();
            for (i, j, a, b) in entries {
                let k = columns.iter().position(|c| c.0 == j).unwrap_or_else(|| {
                    let zeros = || vec![0.0; units.len()];
                    columns.push((j, zeros(), zeros()));
                    columns.len() - 1
                });
                (columns[k].1[i], columns[k].2[i]) = (a, b);
            }
            let name = format!("{} against its transpose", part.name());
            wrong_blocks(&name, Rows::Forces(laws.layout), laws.layout, &columns)
        });
    }

    /// The columns that share a row with a group of rows.
    fn coupled(&self, rows: &std::ops::Range<usize>) -> Vec<usize> {
        let touches = |i: usize| {
            let own = self.pattern.unknowns(i);
            own.start < rows.end && rows.start < own.end
        };
        (0..self.pattern.blocks())
            .filter(|&j| self.pattern.column(j).any(|(i, _)| touches(i)))
            .flat_map(|j| self.pattern.unknowns(j))
            .collect()
    }
}

/// Largest difference of entries of a symmetric matrix, over the magnitudes of their rows.
const SYMMETRIC: f64 = 1e-13;

/// Fraction of the energies in coupled rows that may have cancelled in a row.
const MIXED: f64 = 1e-2;

/// The laws of the tangents at a state; `sizes` are the magnitudes of the terms in each group.
pub(crate) fn tangents(
    laws: &mut Laws<'_>,
    all: &Linearization<'_>,
    sizes: &[f64],
    residual: &mut Residual<'_>,
) {
    for part in Part::ALL {
        if !part.of(&mut laws.state.clone()).is_empty() {
            tangent(laws, all, part, sizes, residual);
        }
    }
}

fn tangent(
    laws: &mut Laws<'_>,
    all: &Linearization<'_>,
    part: Part,
    sizes: &[f64],
    residual: &mut Residual<'_>,
) {
    let layout = laws.layout;
    let scale = layout.rate.powi(part as i32);
    let units: Vec<f64> = layout.units().iter().map(|u| u * scale).collect();
    let d = laws.random.direction_in(&units);
    let slope = all.times(part, d.as_slice());
    let state = laws.state;
    let mut varied = state.clone();
    let base = part.of(&mut varied).clone();
    let nowhere = vec![f64::NAN; layout.groups().len()];
    let worst = laws
        .report
        .slopes(part.law(), laws.at, 2.0, FIRST, sizes, |e| {
            part.of(&mut varied).copy_from(&(&base + &d * e));
            let Some(there) = residual(&varied) else {
                return nowhere.clone();
            };
            let parts = there.iter().zip(all.r).zip(&slope);
            let left: Vec<f64> = parts.map(|((a, b), s)| a - b + s * e).collect();
            layout.forces(&left)
        });
    let row = laws.report.rows().last();
    if row.is_none_or(|r| r.passed || matches!(r.measure, Measure::Impossible(_))) {
        return;
    }
    // Columns by differences confirm the defect, and show where it is.
    let group = &layout.groups()[worst];
    let mut values = Vec::new();
    let mut off: f64 = 0.0;
    for j in all.coupled(&group.range) {
        let h = STEP * units[j];
        let column = difference(h, |e| {
            part.of(&mut varied).copy_from(&base);
            part.of(&mut varied)[j] += e;
            residual(&varied)
        });
        let Some(right) = column else { continue };
        let right: Vec<f64> = right.iter().map(|x| -x).collect();
        let mut one = vec![0.0; units.len()];
        one[j] = 1.0;
        let found = all.times(part, &one);
        let gaps = layout.forces(&minus(&found, &right));
        off = off.max(gaps[worst] * units[j]);
        values.push((j, found, right));
    }
    if values.is_empty() {
        return;
    }
    let allowed = CONFIRMED * sizes[worst];
    laws.report.second_opinion(|| Some((off, allowed)));
    let blocks = || wrong_blocks(part.name(), Rows::Forces(layout), layout, &values);
    laws.report.blame(blocks);
}
