//! A scaled block-sparse matrix in compressed columns for general sparse solvers, with the checks
//! of their factorisations and solutions.

use crate::random::Random;
use crate::vectors::add;
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::CoordinateInfo;

use super::{
    LinearError, check_length, first_non_finite, max_abs, refine, relative, rounding_level, scaling,
};

/// Shift of the diagonal of a scaled matrix whose factors are not finite, to find the direction of
/// its mechanism.
const SHIFT: f64 = 1e-12;

/// The scaled matrix column by column, and the work vectors of the checks.
pub struct Columns {
    pub pattern: BlockPattern,
    pub starts: Vec<usize>,
    pub rows: Vec<usize>,
    pub values: Vec<f64>,
    pub scales: Vec<f64>,
    pub norm: f64,
    pub rhs: Vec<f64>,
    pub x: Vec<f64>,
    pub residual: Vec<f64>,
    pub finished: bool,
}

impl Columns {
    /// The columns of a pattern, without values.
    pub fn new(pattern: &BlockPattern) -> Self {
        let n = pattern.dim();
        let mut starts = Vec::with_capacity(n + 1);
        let mut rows = Vec::with_capacity(pattern.len());
        starts.push(0);
        for j in 0..pattern.blocks() {
            for _ in pattern.unknowns(j) {
                rows.extend(pattern.column(j).flat_map(|(i, _)| pattern.unknowns(i)));
                starts.push(rows.len());
            }
        }
        Self {
            pattern: pattern.clone(),
            starts,
            rows,
            values: vec![0.0; pattern.len()],
            scales: vec![1.0; n],
            norm: 0.0,
            rhs: vec![0.0; n],
            x: vec![0.0; n],
            residual: vec![0.0; n],
            finished: false,
        }
    }

    /// Copies and scales the values.
    pub fn load(&mut self, values: &[f64]) -> Result<(), LinearError> {
        check_length("matrix", self.pattern.len(), values.len())?;
        self.finished = false;
        let pattern = &self.pattern;
        scaling::scales(pattern, values, &mut self.scales, &mut self.x)?;
        self.norm = scaling::norm(pattern, values, &self.scales);
        let mut position = 0;
        for j in 0..pattern.blocks() {
            for (c, unknown) in pattern.unknowns(j).enumerate() {
                for (i, range) in pattern.column(j) {
                    let height = pattern.size(i);
                    let column = &values[range][c * height..(c + 1) * height];
                    for (value, r) in column.iter().zip(pattern.unknowns(i)) {
                        self.values[position] = value * self.scales[r] * self.scales[unknown];
                        position += 1;
                    }
                }
            }
        }
        Ok(())
    }

    /// Adds [`SHIFT`] to the diagonal.
    pub fn shift_diagonal(&mut self) {
        self.shift(|_| SHIFT);
    }

    /// Gives multipliers a compliance.
    pub fn soften(&mut self, compliance: f64) {
        self.shift(|coordinate| match coordinate.is_multiplier {
            true => -compliance,
            false => 0.0,
        });
    }

    /// Adds to the diagonal.
    fn shift(&mut self, by: impl Fn(&CoordinateInfo) -> f64) {
        let (starts, rows) = (&self.starts, &self.rows);
        for c in 0..self.scales.len() {
            let range = starts[c]..starts[c + 1];
            for (value, &r) in self.values[range.clone()].iter_mut().zip(&rows[range]) {
                if r == c {
                    *value += by(&self.pattern.coordinates()[c]);
                }
            }
        }
    }

    /// Solves with `inverse` for a fixed right-hand side without structure (magnitudes between 1/2
    /// and 1, mixed signs); the condition number that the solution, now in `x`, indicates.
    pub fn probe(&mut self, inverse: impl FnOnce(&mut [f64])) -> f64 {
        let mut random = Random(0);
        for x in &mut self.x {
            let r = random.next();
            *x = r + 0.5_f64.copysign(r);
        }
        inverse(&mut self.x);
        self.norm * max_abs(&self.x)
    }

    /// Condition number at which a matrix counts as singular.
    pub fn condition_limit(&self) -> f64 {
        1.0 / rounding_level(self.pattern.blocks())
    }

    /// The error that names the largest component of `x`.
    pub fn singular(&self, condition: f64) -> LinearError {
        // The first of the largest; NaN counts as largest.
        let size = |i: &usize| self.x[*i].abs();
        let largest = (0..self.x.len())
            .rev()
            .max_by(|i, j| size(i).total_cmp(&size(j)));
        LinearError::Singular {
            unknown: largest.unwrap_or(0),
            condition,
            limit: self.condition_limit(),
        }
    }

    /// Solves with `inverse` and checks; `inverse` works on the scaled system.
    pub fn solve(
        &mut self,
        b: &mut [f64],
        mut inverse: impl FnMut(&mut [f64]),
    ) -> Result<(), LinearError> {
        check_length("right-hand side", self.scales.len(), b.len())?;
        if !self.finished {
            return Err(LinearError::NotReady);
        }
        if let Some(unknown) = first_non_finite(b) {
            return Err(LinearError::NonFinite {
                what: "right-hand side",
                unknown,
            });
        }
        for ((y, b), s) in self.rhs.iter_mut().zip(&*b).zip(&self.scales) {
            *y = b * s;
        }
        self.x.copy_from_slice(&self.rhs);
        inverse(&mut self.x);
        refine(self, Self::relative_residual, |this| {
            inverse(&mut this.residual);
            add(&mut this.x, 1.0, &this.residual);
        })?;
        for ((b, x), s) in b.iter_mut().zip(&self.x).zip(&self.scales) {
            *b = x * s;
        }
        Ok(())
    }

    /// Computes `residual = rhs - A x` and its relative size.
    fn relative_residual(&mut self) -> Result<f64, LinearError> {
        let (starts, rows) = (&self.starts, &self.rows);
        self.residual.copy_from_slice(&self.rhs);
        for (c, x) in self.x.iter().enumerate() {
            let range = starts[c]..starts[c + 1];
            for (&r, a) in rows[range.clone()].iter().zip(&self.values[range]) {
                self.residual[r] -= a * x;
            }
        }
        let parts = [&self.residual, &self.x, &self.rhs].map(|x| &x[..]);
        relative(self.norm, parts).ok_or_else(|| LinearError::NonFinite {
            what: "solution",
            unknown: first_non_finite(&self.x).unwrap_or(0),
        })
    }
}
