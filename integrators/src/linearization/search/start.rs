//! The first shift, the inner product, and start vectors.

use super::{DENSE, FINITE, Inner, Krylov, ModesError, Order, Search, Selection};
use crate::linear_solver::LinearError;
use crate::linear_solver::scaling;
use crate::vectors::dot;

/// Square of the length that equations with multipliers leave of a unit vector, relative to its own, that is one of rounding.
const HELD: f64 = 1e-16;

impl<'a> Search<'a> {
    /// A first shift, factorised.
    pub(super) fn first_shift(&mut self) -> Result<f64, ModesError> {
        let from_zero = !self.rigid && (self.order == Order::Quadratic || self.middle == 0.0);
        let shift = if from_zero && self.factorise(0.0).is_ok() {
            0.0
        } else if self.middle != 0.0 {
            self.factorise_near(self.middle)?
        } else {
            // Beyond the spectrum of a rigid structure: K + |σ| M is positive definite.
            let bound = self.lowest();
            self.factorise_near(match self.order {
                Order::Squares => -bound,
                Order::Quadratic => bound.sqrt(),
            })?
        };
        self.weigh()?;
        Ok(shift)
    }

    /// The least K_ii / M_ii that is no rounding error of the largest: about the lowest ω² of a rigid structure.
    fn lowest(&self) -> f64 {
        let least = FINITE * self.ratios().fold(0.0, f64::max);
        let ratios = self.ratios().filter(|x| *x > least);
        let lowest = ratios.fold(f64::INFINITY, f64::min);
        if lowest.is_finite() { lowest } else { 1.0 }
    }

    /// About the largest |λ| or ω² of the search.
    pub(super) fn largest(&self) -> f64 {
        let largest = self.ratios().fold(0.0, f64::max);
        match self.order {
            Order::Squares => largest,
            Order::Quadratic => largest.sqrt(),
        }
    }

    /// K_ii / M_ii where they are finite.
    fn ratios(&self) -> impl Iterator<Item = f64> {
        let diagonal = self.lin.pattern.diagonal();
        let ratios = diagonal.map(|k| self.lin.K[k] / self.lin.M[k]);
        ratios.filter(|x| x.is_finite())
    }

    /// Scales of the shifted matrix, and weights of the coordinates on which the operator depends.
    fn weigh(&mut self) -> Result<(), LinearError> {
        let lin = self.lin;
        let n = lin.dim();
        let (mut scales, mut work) = (vec![1.0; n], vec![0.0; n]);
        let values = self.operator.values();
        // It was factorised: no row is zero.
        let _ = scaling::scales(&lin.pattern, values, &mut scales, &mut work);
        let weights = |matrices: &[&Vec<f64>]| {
            let mut weights = vec![0.0; n];
            for values in matrices {
                lin.pattern.triplets(values).for_each(|(_, c, value)| {
                    if value != 0.0 {
                        weights[c] = scales[c].powi(-2);
                    }
                });
            }
            weights
        };
        self.weights = match self.order {
            Order::Squares => weights(&[&lin.M]),
            Order::Quadratic => weights(&[&lin.C, &lin.M]),
        };
        self.scales = scales;
        if self.order == Order::Quadratic {
            self.balance = self.find_balance()?;
            let masses = lin.pattern.diagonal().map(|k| self.balance * lin.M[k]);
            self.weights.extend(masses);
        }
        Ok(())
    }

    /// The factor of the kinetic energy of velocities with which they count as much as the displacements of modes near the shift.
    ///
    /// Displacements x of such modes become those of the length |x|/|λ|² in two steps of the power method, and their velocities are
    /// λ x.
    fn find_balance(&mut self) -> Result<f64, LinearError> {
        let n = self.lin.dim();
        let length = |x: &[f64], weights: &[f64]| -> f64 {
            let squares = x.iter().zip(weights).map(|(x, w)| w * x * x);
            squares.sum::<f64>().sqrt()
        };
        let mut x = vec![0.0; 2 * n];
        x.fill_with(|| self.random.next());
        x = self.operator.apply(&x, None)?;
        x[n..].fill(0.0);
        let kinetic = dot(&self.lin.product(&self.lin.M, &x[..n]), &x[..n]);
        let before = length(&x[..n], &self.weights);
        for _ in 0..2 {
            x = self.operator.apply(&x, None)?;
        }
        // A power of four, whose root adds no rounding errors; of no use without mass.
        let power = (before * length(&x[..n], &self.weights) / kinetic)
            .log(4.0)
            .round();
        Ok(if power.is_finite() {
            4.0_f64.powf(power)
        } else {
            1.0
        })
    }

    /// The inner product of the search: M if the problem is symmetric, and of velocities, so that what has no mass has no
    /// length.
    fn gram(&self) -> impl Fn(&[f64], &mut [f64]) + use<'a> {
        let (lin, inner, weights) = (self.lin, self.inner, self.weights.clone());
        let factor = self.balance;
        let by_mass = match inner {
            Inner::Mass => true,
            Inner::Stiffness => false,
            Inner::Coordinates => lin.is_symmetric(&lin.M),
        };
        move |x, y| {
            if inner == Inner::Stiffness {
                lin.pattern.multiply_add(1.0, &lin.K, x, y);
                return;
            }
            let others = x.len() - if by_mass { lin.dim() } else { 0 };
            for ((y, x), w) in y[..others].iter_mut().zip(x).zip(&weights) {
                *y += w * x;
            }
            if by_mass {
                let (x, y) = (&x[others..], &mut y[others..]);
                lin.pattern.multiply_add(factor, &lin.M, x, y);
            }
        }
    }

    /// A subspace without vectors.
    pub(super) fn empty(&self) -> Krylov<'a> {
        let size = self.weights.len();
        // Of what equations hold there are no finite eigenvalues.
        let free = self.operator.free_coordinates() * (size / self.lin.dim());
        Krylov::new([size, free], self.is_symmetric(), self.gram())
    }

    /// A subspace of start vectors: all unit vectors if there are few, else one.
    pub(super) fn krylov(&mut self) -> Result<Krylov<'a>, ModesError> {
        let (size, mut krylov) = (self.weights.len(), self.empty());
        let few = match self.selection {
            Selection::Nearest { count, .. } => size <= DENSE.max(4 * count),
            Selection::Range(_) => size <= DENSE,
        };
        if !few {
            self.add_starts(&mut krylov, 1)?;
            return Ok(krylov);
        }
        for i in 0..size {
            let mut unit = vec![0.0; size];
            unit[i] = 1.0;
            self.operator.constrain(&mut unit)?;
            // Of what equations hold, and of multipliers, rounding errors are left.
            let whole = match self.weights[i] {
                0.0 => self.scales[i % self.lin.dim()].powi(-2),
                own => own,
            };
            let left: f64 = unit.iter().zip(&self.weights).map(|(x, w)| w * x * x).sum();
            if left > HELD * whole {
                krylov.add(unit);
            }
        }
        Ok(krylov)
    }

    /// Adds pseudo-random start vectors in the range of the operator; false if the basis holds them.
    pub(super) fn add_starts(
        &mut self,
        krylov: &mut Krylov<'_>,
        count: usize,
    ) -> Result<bool, ModesError> {
        let mut added = false;
        for _ in 0..count {
            let random = &mut self.random;
            let scaled = |w: &f64| random.next() * if *w > 0.0 { w.sqrt().recip() } else { 0.0 };
            let mut vector: Vec<f64> = self.weights.iter().map(scaled).collect();
            self.operator.constrain(&mut vector)?;
            let vector = self.operator.apply(&vector, None)?;
            added |= krylov.add(vector);
        }
        Ok(added)
    }
}
