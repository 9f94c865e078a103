//! Solutions by the block factors: substitution, and the residual.

use super::factors::Factors;
use super::symbolic::ColumnPanel;
use super::{LinearError, MatrixSymmetry, first_non_finite, kernels, refine, relative};
use crate::vectors::add;

impl Factors {
    /// Scaled right-hand side in elimination order, into `y`.
    pub fn gather(&mut self, b: &[f64]) {
        for panel in &self.symbolic.panels {
            let range = panel.first..panel.first + panel.size;
            let b = &b[panel.unknown..panel.unknown + panel.size];
            for ((y, b), s) in self.y[range.clone()]
                .iter_mut()
                .zip(b)
                .zip(&self.scales[range])
            {
                *y = b * s;
            }
        }
    }

    /// The solution in `y` with its scales undone, in the order of the matrix.
    pub fn scatter(&self, b: &mut [f64]) {
        for panel in &self.symbolic.panels {
            let range = panel.first..panel.first + panel.size;
            let b = &mut b[panel.unknown..panel.unknown + panel.size];
            for ((b, y), s) in b
                .iter_mut()
                .zip(&self.y[range.clone()])
                .zip(&self.scales[range])
            {
                *b = y * s;
            }
        }
    }

    /// Solves for the vector in `y`, in place.
    pub fn substitute(&mut self) {
        for k in 0..self.symbolic.panels.len() {
            self.forward(k);
        }
        self.substitute_back();
    }

    /// Substitutes the unknowns of panel `k` through the lower factor, and subtracts their share from
    /// later ones.
    #[inline(always)]
    pub fn forward(&mut self, k: usize) {
        let symbolic = &self.symbolic;
        let panel = &symbolic.panels[k];
        let n = panel.size;
        let (left, right) = self.y.split_at_mut(panel.first + n);
        let own = &mut left[panel.first..];
        if self.swapped[k] {
            for (i, &row) in self.swaps[panel.first..panel.first + n].iter().enumerate() {
                own.swap(i, row as usize);
            }
        }
        kernels::solve_lower(n, &self.factors[panel.start..], own);
        for link in &symbolic.links[symbolic.links_of(k)] {
            let later = &mut right[link.first - panel.first - n..];
            kernels::subtract(link.size, n, &self.factors[link.start..], own, later);
        }
    }

    /// The second half: backward substitution through the upper factor.
    pub fn substitute_back(&mut self) {
        let symbolic = &self.symbolic;
        let y = &mut self.y;
        for k in (0..symbolic.panels.len()).rev() {
            let panel = &symbolic.panels[k];
            let n = panel.size;
            let (left, right) = y.split_at_mut(panel.first + n);
            let own = &mut left[panel.first..];
            for link in &symbolic.links[symbolic.links_of(k)] {
                let later = &right[link.first - panel.first - n..];
                let ut = &self.factors[link.start + link.size * n..];
                kernels::subtract_transposed(link.size, n, ut, later, own);
            }
            kernels::solve_upper(n, &self.factors[panel.start..], own);
        }
    }

    /// Refines the solution in `y` until its residual is small enough.
    pub fn refine(&mut self, values: &[f64], b: &[f64]) -> Result<(), LinearError> {
        self.x.copy_from_slice(&self.y);
        self.gather(b);
        self.rhs.copy_from_slice(&self.y);
        let residual = |this: &mut Self| this.relative_residual(values, b);
        refine(self, residual, |this| {
            this.substitute();
            add(&mut this.x, 1.0, &this.y);
        })?;
        self.y.copy_from_slice(&self.x);
        Ok(())
    }

    /// Computes `y = rhs - A x` for the matrix with these values, and its relative size.
    fn relative_residual(&mut self, values: &[f64], b: &[f64]) -> Result<f64, LinearError> {
        let symbolic = &self.symbolic;
        let (r, x) = (&mut self.y, &mut self.unscaled);
        // Scales are powers of two, so dividing and multiplying by them is exact.
        for (i, s) in self.scales.iter().enumerate() {
            r[i] = self.rhs[i] / s;
            x[i] = self.x[i] * s;
        }
        for load in &symbolic.loads {
            let (row, column) = (&symbolic.panels[load.row], &symbolic.panels[load.column]);
            let (m, n) = (row.size, column.size);
            let lower = &values[load.lower..];
            kernels::subtract(m, n, lower, &x[column.first..], &mut r[row.first..]);
            if load.row != load.column {
                let (x, y) = (&x[row.first..], &mut r[column.first..]);
                match symbolic.symmetry {
                    MatrixSymmetry::Symmetric => kernels::subtract_transposed(m, n, lower, x, y),
                    MatrixSymmetry::General => kernels::subtract(n, m, &values[load.upper..], x, y),
                }
            }
        }
        for (r, s) in r.iter_mut().zip(&self.scales) {
            *r *= s;
        }
        if let Some(relative) = relative(self.norm, [&self.y, &self.x, &self.rhs]) {
            return Ok(relative);
        }
        if let Some(unknown) = first_non_finite(b) {
            return Err(LinearError::NonFinite {
                what: "right-hand side",
                unknown,
            });
        }
        let x = &self.x;
        let bad = |p: &ColumnPanel| {
            first_non_finite(&x[p.first..p.first + p.size]).map(|i| p.unknown + i)
        };
        Err(LinearError::NonFinite {
            what: "solution",
            unknown: symbolic.panels.iter().find_map(bad).unwrap_or(0),
        })
    }
}
