//! Coordinates in groups with a name and a unit, in which errors are compared and reported.

use crate::vectors::norm;
use pullback_manifold::system::System;
use std::ops::Range;

/// A group of coordinates, such as the displacement of a node.
#[derive(Clone, Debug, PartialEq)]
pub struct CoordinateGroup {
    /// Name of the group.
    pub name: String,
    /// Numbers of the coordinates.
    pub range: Range<usize>,
    /// A typical change of one of them, such as a length of the component or one radian. Coordinates are divided by
    /// it and forces multiplied, so that products of both are energies.
    pub unit: f64,
    /// Magnitude, in units, of numbers to which the coordinates are added, such as the distance of a node from the
    /// origin: a displacement loses as many digits.
    pub reach: f64,
}

/// The groups of all coordinates of a component or model.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    groups: Vec<CoordinateGroup>,
    /// A typical rate of change: velocities are of the size of a unit times this.
    pub rate: f64,
}

impl Layout {
    /// A layout of groups of all coordinates, in any order.
    pub fn new(mut groups: Vec<CoordinateGroup>) -> Self {
        groups.sort_by_key(|g| g.range.start);
        Self { groups, rate: 1.0 }
    }

    /// The layout of the only column of a vector.
    pub fn single() -> Self {
        Self::new(vec![CoordinateGroup {
            name: String::new(),
            range: 0..1,
            unit: 1.0,
            reach: 0.0,
        }])
    }

    /// A layout of `n` coordinates without names: groups of three with unit 1.
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

    /// A layout of coordinates without names, with a unit each.
    pub(crate) fn in_units(units: &[f64]) -> Self {
        let group = |(k, unit): (usize, &f64)| CoordinateGroup {
            name: format!("coordinate {}", k + 1),
            range: k..k + 1,
            unit: *unit,
            reach: 0.0,
        };
        Self::new(units.iter().enumerate().map(group).collect())
    }

    /// The groups.
    pub fn groups(&self) -> &[CoordinateGroup] {
        &self.groups
    }

    /// The unit of each coordinate.
    pub fn units(&self) -> Vec<f64> {
        self.spread(|g| g.unit)
    }

    /// The magnitude of each coordinate, velocity or acceleration (`order` 0, 1, 2): the sum of its value, its unit
    /// and its reach.
    pub fn magnitudes(&self, x: &[f64], order: i32) -> Vec<f64> {
        let rate = self.rate.powi(order);
        let least = self.spread(|g| match order {
            0 => g.unit * (1.0 + g.reach),
            _ => g.unit * rate,
        });
        least.iter().zip(x).map(|(b, x)| b + x.abs()).collect()
    }

    fn spread(&self, of: impl Fn(&CoordinateGroup) -> f64) -> Vec<f64> {
        let mut out = Vec::new();
        for g in &self.groups {
            out.extend(std::iter::repeat_n(of(g), g.range.len()));
        }
        out
    }

    /// The layout of a system: consecutive coordinates of a block with the same quantity form a group.
    pub fn of(system: &dyn System) -> Self {
        let pattern = system.pattern();
        let mut groups: Vec<CoordinateGroup> = Vec::new();
        for block in 0..pattern.blocks() {
            let all = pattern.unknowns(block);
            let mut first = all.start;
            for own in pattern.coordinates()[all].chunk_by(|a, b| a.quantity == b.quantity) {
                let range = first..first + own.len();
                first = range.end;
                let names = [range.start, range.end - 1].map(|i| system.name(i));
                groups.push(CoordinateGroup {
                    name: match range.len() {
                        1 => names[0].clone(),
                        _ => format!("{} to {}", names[0], names[1]),
                    },
                    unit: own[0].size,
                    reach: 0.0,
                    range,
                });
            }
        }
        Self::new(groups)
    }

    /// The norm of each group's forces as energies.
    pub fn forces(&self, r: &[f64]) -> Vec<f64> {
        let norm = |g: &CoordinateGroup| g.unit * norm(&r[g.range.clone()]);
        self.groups.iter().map(norm).collect()
    }

    /// The norm of each group's coordinates in units.
    pub fn coordinates(&self, x: &[f64]) -> Vec<f64> {
        let norm = |g: &CoordinateGroup| norm(&x[g.range.clone()]) / g.unit;
        self.groups.iter().map(norm).collect()
    }
}
