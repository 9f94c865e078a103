//! A seeded random generator, and the positions at which laws are checked.

use nalgebra::{DVector, SVector, Vector3};
use std::f64::consts::{PI, TAU};

/// Points closer than this to the boundary of a domain are left out.
pub(crate) const CLEARANCE: f64 = 0.02;

/// Names of the positions and the norm of every three consecutive coordinates there; `None` stands for a random norm.
const POSITIONS: [(&str, Option<f64>); 8] = [
    ("0", Some(0.0)),
    ("1e-8", Some(1e-8)),
    ("random 1", None),
    ("random 2", None),
    ("random 3", None),
    ("pi - 1e-3", Some(PI - 1e-3)),
    ("pi + 1e-3", Some(PI + 1e-3)),
    ("2pi - 0.3", Some(TAU - 0.3)),
];

/// A small seeded generator (splitmix64): the same numbers on every machine.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Default for Random {
    fn default() -> Self {
        Self::new(0x5EED)
    }
}

impl Random {
    /// A generator with a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next number in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// The next number in [from, to).
    pub fn range(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    /// Fills a slice from [−1, 1).
    pub fn fill(&mut self, out: &mut [f64]) {
        out.iter_mut().for_each(|x| *x = self.range(-1.0, 1.0));
    }

    /// A vector with entries in [−1, 1).
    pub fn vector<const D: usize>(&mut self) -> SVector<f64, D> {
        let mut out = SVector::<f64, D>::zeros();
        self.fill(out.as_mut_slice());
        out
    }

    /// A vector with entries in [−1, 1) times these units.
    pub(crate) fn entries(&mut self, units: &[f64]) -> DVector<f64> {
        let mut out = DVector::zeros(units.len());
        self.fill(out.as_mut_slice());
        out.component_mul(&DVector::from_column_slice(units))
    }

    /// A direction of norm 1, each entry times its unit.
    pub(crate) fn direction_in(&mut self, units: &[f64]) -> DVector<f64> {
        let mut out = DVector::zeros(units.len());
        self.direction(1.0, out.as_mut_slice());
        out.component_mul(&DVector::from_column_slice(units))
    }

    /// Fills a slice with a random direction of the given norm.
    pub fn direction(&mut self, norm: f64, out: &mut [f64]) {
        // A short vector has few digits: another one is drawn.
        loop {
            self.fill(out);
            let length = out.iter().map(|x| x * x).sum::<f64>().sqrt();
            if length > 0.1 || out.is_empty() {
                out.iter_mut().for_each(|x| *x *= norm / length);
                return;
            }
        }
    }

    /// A vector of a norm in a random direction.
    pub(crate) fn of_norm(&mut self, norm: f64) -> Vector3<f64> {
        let mut out = Vector3::zeros();
        self.direction(norm, out.as_mut_slice());
        out
    }

    /// All positions with this number of coordinates, with their names. Every three consecutive coordinates have the
    /// norm of the position and a random direction.
    pub(crate) fn positions(&mut self, dim: usize) -> Vec<(&'static str, Vec<f64>)> {
        let mut position = |(name, norm): (&'static str, Option<f64>)| {
            let mut q = vec![0.0; dim];
            for triple in q.chunks_mut(3) {
                let norm = norm.unwrap_or_else(|| self.range(0.3, 2.8));
                self.direction(norm, triple);
            }
            (name, q)
        };
        POSITIONS.map(&mut position).to_vec()
    }
}
