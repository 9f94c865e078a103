//! Coordinates in groups that have a name and a size: what makes defects comparable and readable.

use pullback_manifold::system::System;
use std::ops::Range;

/// Coordinates that stand together: the displacement of a node, say.
#[derive(Clone, Debug, PartialEq)]
pub struct CoordinateGroup {
    /// Their name.
    pub name: String,
    /// Which they are.
    pub range: Range<usize>,
    /// A typical change of one of them: a length of the component, one radian. Coordinates are
    /// divided by it and their forces multiplied, which makes all of them energies.
    pub unit: f64,
    /// Magnitude of the numbers behind them in units, as far as coordinates do not show it: the
    /// distance of a node from the origin, in which its displacement may lose digits.
    pub reach: f64,
}

/// All coordinates of something, group by group.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    groups: Vec<CoordinateGroup>,
    /// A typical rate of change: velocities are of the size of a unit times this.
    pub rate: f64,
}

impl Layout {
    /// Of groups one after the other.
    pub fn new(groups: Vec<CoordinateGroup>) -> Self {
        Self { groups, rate: 1.0 }
    }

    /// Of a vector that stands alone: the one column of a matrix.
    pub fn single() -> Self {
        Self::new(vec![CoordinateGroup {
            name: String::new(),
            range: 0..1,
            unit: 1.0,
            reach: 0.0,
        }])
    }

    /// Of `n` coordinates without names: groups of three of unit size.
    pub fn plain(n: usize) -> Self {
        let group = |first: usize| {
            let last = (first + 3).min(n);
            CoordinateGroup {
                name: match last - first {
                    1 => format!("coordinate {last}"),
                    _ => format!("coordinates {} to {last}", first + 1),
                },
                range: first..last,
                unit: 1.0,
                reach: 0.0,
            }
        };
        Self::new((0..n).step_by(3).map(group).collect())
    }

    /// The groups.
    pub fn groups(&self) -> &[CoordinateGroup] {
        &self.groups
    }

    /// The unit of each coordinate.
    pub fn units(&self) -> Vec<f64> {
        self.spread(|g| g.unit)
    }

    /// The magnitude of each coordinate (velocity, acceleration: `order` 1, 2): its value, its unit,
    /// and what stands behind it.
    pub fn magnitudes(&self, x: &[f64], order: i32) -> Vec<f64> {
        let rate = self.rate.powi(order);
        let behind = self.spread(|g| match order {
            0 => g.unit * (1.0 + g.reach),
            _ => g.unit * rate,
        });
        behind.iter().zip(x).map(|(b, x)| b + x.abs()).collect()
    }

    fn spread(&self, of: impl Fn(&CoordinateGroup) -> f64) -> Vec<f64> {
        let mut out = Vec::new();
        for g in &self.groups {
            out.extend(std::iter::repeat_n(of(g), g.range.len()));
        }
        out
    }

    /// That of a system by what it says of its coordinates: those of one block that measure the same
    /// make a group.
    pub fn of(system: &dyn System) -> Self {
        let pattern = system.pattern();
        let mut groups: Vec<CoordinateGroup> = Vec::new();
        for block in 0..pattern.blocks() {
            let all = pattern.unknowns(block);
            let mut first = all.start;
            while first < all.end {
                let kind = system.coordinate_info(first).quantity;
                let end = (first..all.end).find(|&i| system.coordinate_info(i).quantity != kind);
                let range = first..end.unwrap_or(all.end);
                let names = [range.start, range.end - 1].map(|i| system.name(i));
                groups.push(CoordinateGroup {
                    name: match range.len() {
                        1 => names[0].clone(),
                        _ => format!("{} to {}", names[0], names[1]),
                    },
                    unit: system.scales().coordinate[kind.index()],
                    reach: 0.0,
                    range: range.clone(),
                });
                first = range.end;
            }
        }
        Self::new(groups)
    }

    /// The norm of each group's forces as energies.
    pub fn forces(&self, r: &[f64]) -> Vec<f64> {
        let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        self.groups
            .iter()
            .map(|g| g.unit * norm(&r[g.range.clone()]))
            .collect()
    }

    /// The norm of each group's coordinates in units.
    pub fn coordinates(&self, x: &[f64]) -> Vec<f64> {
        let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        self.groups
            .iter()
            .map(|g| norm(&x[g.range.clone()]) / g.unit)
            .collect()
    }
}
