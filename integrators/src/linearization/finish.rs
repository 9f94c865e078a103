//! Modes of the eigenvectors of a search: eigenvalues, scale and residuals.

#![allow(non_snake_case)]

use super::Linearized;
use super::modes::Mode;
use super::search::Parts;
use super::shift_invert::Order;
use crate::linear_solver::scaling;
use crate::vectors::{add, dot};
use num_complex::Complex64;

/// Rounding errors of φᵀ K φ in units of those of its terms.
pub(super) const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Makes modes of eigenvectors: their eigenvalues, scale and residual.
pub(super) struct Finish<'a> {
    lin: &'a Linearized,
    order: Order,
    symmetric: bool,
    scales: Vec<f64>,
    norms: [f64; 3],
}

impl<'a> Finish<'a> {
    /// `scales` make the shifted matrix one of entries of order one.
    pub fn new(lin: &'a Linearized, order: Order, symmetric: bool, scales: Vec<f64>) -> Self {
        let norm = |values: &[f64]| scaling::norm(&lin.pattern, values, &scales);
        let damping = match order {
            Order::Squares => 0.0,
            Order::Quadratic => norm(&lin.C),
        };
        Self {
            norms: [norm(&lin.K), damping, norm(&lin.M)],
            lin,
            order,
            symmetric,
            scales,
        }
    }

    /// A mode of an eigenvector of any length, and the eigenvalue of the search: ω² or λ.
    pub fn mode(&self, shape: &Parts, found: Complex64) -> Mode {
        let lin = self.lin;
        let images = match self.order {
            Order::Squares => [Some(&lin.K), None, Some(&lin.M)],
            Order::Quadratic => [&lin.K, &lin.C, &lin.M].map(Some),
        };
        let images = images.map(|values| match values {
            Some(values) => shape.each_ref().map(|part| self.product(values, part)),
            None => Parts::default(),
        });
        // φᴴ y, real for a symmetric matrix.
        let form = |[re, im]: &Parts| dot(&shape[0], re) + dot(&shape[1], im);
        let mass = form(&images[2]);
        let eigenvalue = self.eigenvalue(shape, found, [form(&images[0]), mass]);
        let residual = self.residual(shape, &images, eigenvalue);
        let [re, im] = shape;
        let mut complex: Vec<Complex64> = match im.is_empty() {
            true => re.iter().map(|re| (*re).into()).collect(),
            false => re
                .iter()
                .zip(im)
                .map(|(re, im)| Complex64::new(*re, *im))
                .collect(),
        };
        let mut largest = (0.0, Complex64::ONE);
        for (x, s) in complex.iter().zip(&self.scales) {
            let size = x.norm_sqr() / (s * s);
            if size > largest.0 {
                largest = (size, *x);
            }
        }
        let has_mass = mass > ROUNDING * self.norms[2] * self.square(shape);
        let size = if has_mass {
            mass.sqrt()
        } else {
            largest.1.norm()
        };
        let factor = largest.1.conj() / (largest.1.norm() * size);
        complex.iter_mut().for_each(|x| *x *= factor);
        Mode {
            // No negative zero.
            eigenvalue: eigenvalue + Complex64::ZERO,
            shape: complex,
            residual,
        }
    }

    /// λ of a mode with the forms φᴴ K φ and φᴴ M φ, from the eigenvalue of the search.
    fn eigenvalue(&self, shape: &Parts, found: Complex64, forms: [f64; 2]) -> Complex64 {
        let value = match (self.order, self.symmetric) {
            (Order::Quadratic, _) => found,
            // The quotient's error is the square of the eigenvector's.
            (Order::Squares, true) => Complex64::from(-forms[0] / forms[1]).sqrt(),
            (Order::Squares, false) => (-found).sqrt(),
        };
        if self.is_rigid(shape, value.norm(), forms) {
            return Complex64::ZERO;
        }
        match value {
            // No sign of a damping that is a rounding error.
            Complex64 { re, im } if re.abs() <= ROUNDING * im.abs() => {
                Complex64::new(0.0, im.abs())
            }
            value if value.im < 0.0 => -value,
            value => value,
        }
    }

    /// Whether a mode at rest was found before: with velocities, λ = 0 occurs twice for each.
    pub fn repeats(&self, modes: &[Mode], mode: &Mode) -> bool {
        if self.order == Order::Squares || mode.eigenvalue != Complex64::ZERO {
            return false;
        }
        let part = |part: fn(&Complex64) -> f64| {
            let part: Vec<f64> = mode.shape.iter().map(part).collect();
            self.product(&self.lin.M, &part)
        };
        let (re, im) = (part(|x| x.re), part(|x| x.im));
        let rigid = modes.iter().filter(|m| m.eigenvalue == Complex64::ZERO);
        let parts = rigid.map(|m| {
            let images = re.iter().zip(&im).map(|(re, im)| Complex64::new(*re, *im));
            let terms = m.shape.iter().zip(images).map(|(x, y)| x.conj() * y);
            terms.sum::<Complex64>().norm_sqr()
        });
        parts.sum::<f64>() > 0.99
    }

    /// Whether λ is zero but for rounding errors of a mode of this shape φ, with the forms φᴴ K φ and φᴴ M φ.
    fn is_rigid(&self, shape: &Parts, lambda: f64, [stiffness, mass]: [f64; 2]) -> bool {
        let square = self.square(shape);
        let inertia = lambda * lambda * mass;
        let whole = self.norms.map(|norm| ROUNDING * norm * square);
        if stiffness.abs().max(inertia) > whole[0] && lambda * mass > whole[1] {
            return false;
        }
        let [re, im] = shape;
        let mut sizes: Vec<f64> = re.iter().map(|x| x.abs()).collect();
        for (size, im) in sizes.iter_mut().zip(im) {
            *size = size.hypot(*im);
        }
        let mut sum = 0.0;
        for (r, c, K) in self.lin.pattern.triplets(&self.lin.K) {
            sum += K.abs() * sizes[r] * sizes[c];
        }
        // Entries of φ have rounding errors themselves.
        let sum = ROUNDING * (sum + whole[0]);
        stiffness.abs() <= sum && (inertia <= sum || lambda * mass <= whole[1])
    }

    /// Square of the length of a vector in scaled coordinates.
    fn square(&self, x: &Parts) -> f64 {
        let squares = |x: &Vec<f64>| -> f64 {
            let scaled = x.iter().zip(&self.scales);
            scaled.map(|(x, s)| (x / s).powi(2)).sum()
        };
        x.iter().map(squares).sum()
    }

    /// Length of (K + λ C + λ² M) φ, relative to the bounds of the three terms.
    fn residual(&self, shape: &Parts, images: &[Parts; 3], eigenvalue: Complex64) -> f64 {
        let factors = [Complex64::ONE, eigenvalue, eigenvalue * eigenvalue];
        let mut sums = [(); 2].map(|()| vec![0.0; self.lin.dim()]);
        let mut bound = 0.0;
        for (([re, im], factor), norm) in images.iter().zip(factors).zip(self.norms) {
            for (k, weight, part) in [
                (0, factor.re, re),
                (0, -factor.im, im),
                (1, factor.im, re),
                (1, factor.re, im),
            ] {
                if weight != 0.0 {
                    add(&mut sums[k], weight, part);
                }
            }
            bound += factor.norm() * norm;
        }
        let scaled = |r: &Vec<f64>| -> f64 {
            let scaled = r.iter().zip(&self.scales);
            scaled.map(|(r, s)| (r * s).powi(2)).sum()
        };
        let square: f64 = sums.iter().map(scaled).sum();
        // Of λ = 0 without stiffness, all terms are zero.
        match bound {
            0.0 => 0.0,
            _ => (square / self.square(shape)).sqrt() / bound,
        }
    }

    /// A x; of nothing, nothing.
    fn product(&self, values: &[f64], x: &[f64]) -> Vec<f64> {
        match x {
            [] => Vec::new(),
            x => self.lin.product(values, x),
        }
    }
}
