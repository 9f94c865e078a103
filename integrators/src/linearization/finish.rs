//! Modes of the eigenvectors of a search: eigenvalues, scale and residuals.

use super::modes::Mode;
use super::shift_invert::Order;
use super::{Linearized, inner_product};
use crate::linear_solver::scaling;
use num_complex::Complex64;

/// Rounding errors of φᵀ K φ in units of those of its terms.
pub(super) const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Square of a part of a shape, relative to the whole, that is no shape of its own.
const PART: f64 = 1e-6;

/// Part of a shape in another one whose square is no error of the eigenvalue.
const ORTHOGONAL: f64 = 1e-9;

/// Distance of eigenvalues that are one, relative to their size.
const REPEATED: f64 = 1e-9;

/// Makes modes of eigenvectors: their eigenvalues, scale and residual.
pub(super) struct Finish<'a> {
    lin: &'a Linearized,
    order: Order,
    symmetric: bool,
    scales: Vec<f64>,
    norms: [f64; 3],
    errors: Vec<f64>,
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
            errors: lin.rounding_errors(&lin.K),
            lin,
            order,
            symmetric,
            scales,
        }
    }

    /// The mode of an eigenvector of any length, and the eigenvalue of the search: ω² or λ. Two modes that do not oscillate
    /// may have been found as a pair, of which they are the real and imaginary part.
    pub fn modes(&self, shape: Vec<Complex64>, found: Complex64) -> Vec<Mode> {
        let mode = self.mode(shape, found);
        if self.order == Order::Squares || mode.eigenvalue.im > REPEATED * mode.omega() {
            return vec![mode];
        }
        let (found, rests) = (found.re.into(), |mode: &Mode| mode.omega() == 0.0);
        let size = self.square(&mode.shape);
        let parts = [|x: &Complex64| x.re, |x: &Complex64| x.im];
        let parts = parts.map(|part| mode.shape.iter().map(|x| part(x).into()).collect());
        let parts = parts
            .into_iter()
            .filter(|x: &Vec<Complex64>| self.square(x) > PART * size);
        let parts: Vec<Mode> = parts.map(|x| self.mode(x, found)).collect();
        match parts.iter().all(|part| rests(part) == rests(&mode)) {
            true => parts,
            false => vec![mode],
        }
    }

    /// One mode of an eigenvector.
    fn mode(&self, mut shape: Vec<Complex64>, found: Complex64) -> Mode {
        let lin = self.lin;
        let image = |values: &[f64]| lin.product(values, &shape);
        let damping = match self.order {
            Order::Squares => Vec::new(),
            Order::Quadratic => image(&lin.C),
        };
        let images = [image(&lin.K), damping, image(&lin.M)];
        // φᴴ y, real for a symmetric matrix.
        let form = |y: &[Complex64]| inner_product(&shape, y).re;
        let damping = inner_product(&shape[..images[1].len()], &images[1]).norm();
        let forms @ [_, _, mass] = [form(&images[0]), damping, form(&images[2])];
        let eigenvalue = self.eigenvalue(&shape, found, forms);
        let residual = self.residual(&shape, images, eigenvalue);
        let mut largest = (0.0, Complex64::ONE);
        for (x, s) in shape.iter().zip(&self.scales) {
            let size = x.norm_sqr() / (s * s);
            if size > largest.0 {
                largest = (size, *x);
            }
        }
        // Multipliers move nothing, however large they are.
        let coordinates = shape.iter().zip(lin.pattern.coordinates());
        let moves = coordinates.map(|(x, info)| if info.is_multiplier { 0.0.into() } else { *x });
        let square = self.square(&moves.collect::<Vec<_>>());
        let has_mass = mass > ROUNDING * self.norms[2] * square;
        let size = if has_mass {
            mass.sqrt()
        } else {
            largest.1.norm()
        };
        let factor = largest.1.conj() / (largest.1.norm() * size);
        shape.iter_mut().for_each(|x| *x *= factor);
        Mode {
            // No negative zero.
            eigenvalue: eigenvalue + Complex64::ZERO,
            shape,
            residual,
        }
    }

    /// λ of a mode with the forms φᴴ K φ, |φᴴ C φ| and φᴴ M φ, from the eigenvalue of the search.
    fn eigenvalue(&self, shape: &[Complex64], found: Complex64, forms: [f64; 3]) -> Complex64 {
        let value = match (self.order, self.symmetric) {
            (Order::Quadratic, _) => found,
            // The quotient's error is the square of the eigenvector's.
            (Order::Squares, true) => Complex64::from(-forms[0] / forms[2]).sqrt(),
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

    /// A mode without its parts in those before: of a symmetric problem in all, which may have been found with more digits, else
    /// in those with the same eigenvalue, of which the search has found any shapes in their space. `None` of a mode at rest that
    /// was found before: with velocities, λ = 0 occurs twice for each.
    pub fn apart(&self, modes: &[Mode], mode: Mode, found: Complex64) -> Option<Mode> {
        let before = |other: &&Mode| {
            let distance = (other.eigenvalue - mode.eigenvalue).norm();
            self.symmetric || distance <= REPEATED * mode.omega()
        };
        let others: Vec<&Mode> = modes.iter().filter(before).collect();
        if others.is_empty() {
            return Some(mode);
        }
        let mass = |x: &[Complex64]| self.lin.product(&self.lin.M, x);
        let square = |x: &[Complex64]| inner_product(x, &mass(x)).re;
        let scaled = |x: &[Complex64]| -> Vec<Complex64> {
            let scaled = x.iter().zip(&self.scales);
            scaled.map(|(x, s)| x / (s * s)).collect()
        };
        let mut shape = mode.shape.clone();
        // Shapes with mass are of unit mass, and orthogonal to each other.
        let image = mass(&shape);
        let mut is_apart = true;
        for other in &others {
            let part = inner_product(&other.shape, &image);
            subtract(&mut shape, &other.shape, part);
            is_apart &= part.norm() <= ORTHOGONAL;
        }
        if square(&shape) > PART {
            return match is_apart {
                true => Some(mode),
                false => Some(self.mode(shape, found)),
            };
        }
        if self.order == Order::Squares || mode.eigenvalue != Complex64::ZERO {
            return Some(mode);
        }
        for other in others.iter().filter(|other| square(&other.shape) <= PART) {
            let part = inner_product(&scaled(&other.shape), &shape) / self.square(&other.shape);
            subtract(&mut shape, &other.shape, part);
        }
        (self.square(&shape) > PART * self.square(&mode.shape)).then(|| self.mode(shape, found))
    }

    /// Whether λ is zero but for rounding errors of a mode of this shape φ, with the forms φᴴ K φ, |φᴴ C φ| and φᴴ M φ: where
    /// the first is, and λ C and λ² M do not balance each other, or are rounding errors themselves.
    fn is_rigid(
        &self,
        shape: &[Complex64],
        lambda: f64,
        [stiffness, damping, mass]: [f64; 3],
    ) -> bool {
        let square = self.square(shape);
        let inertia = lambda * lambda * mass;
        let whole = self.norms.map(|norm| ROUNDING * norm * square);
        let errors = self.errors.iter().zip(shape);
        let errors: f64 = errors.map(|(e, x)| e * e * x.norm_sqr()).sum();
        if stiffness.abs() > errors + 2.0 * whole[0] {
            return false;
        }
        let sizes: Vec<f64> = shape.iter().map(|x| x.norm()).collect();
        let mut sum = 0.0;
        let entries = self.lin.pattern.triplets(&self.lin.K);
        entries.for_each(|(r, c, K)| sum += K.abs() * sizes[r] * sizes[c]);
        // Entries of φ have rounding errors themselves.
        let sum = errors + ROUNDING * (sum + whole[0]);
        let others = inertia <= sum || lambda * mass <= whole[1] || lambda * mass > 2.0 * damping;
        stiffness.abs() <= sum && others
    }

    /// Square of the length of a vector in scaled coordinates.
    fn square(&self, x: &[Complex64]) -> f64 {
        let scaled = x.iter().zip(&self.scales);
        scaled.map(|(x, s)| (x / s).norm_sqr()).sum()
    }

    /// Length of (K + λ C + λ² M) φ, relative to the bounds of the three terms; `images` are the products K φ, C φ and M φ.
    fn residual(
        &self,
        shape: &[Complex64],
        [mut sum, damping, inertia]: [Vec<Complex64>; 3],
        eigenvalue: Complex64,
    ) -> f64 {
        let [stiffness, damped, mass] = self.norms;
        let square = eigenvalue * eigenvalue;
        for (image, factor) in [(damping, eigenvalue), (inertia, square)] {
            for (sum, x) in sum.iter_mut().zip(image) {
                *sum += factor * x;
            }
        }
        let bound = stiffness + eigenvalue.norm() * damped + square.norm() * mass;
        let scaled = sum.iter().zip(&self.scales);
        let square: f64 = scaled.map(|(r, s)| (r * s).norm_sqr()).sum();
        // Of λ = 0 without stiffness, all terms are zero.
        match bound {
            0.0 => 0.0,
            _ => (square / self.square(shape)).sqrt() / bound,
        }
    }
}

/// Removes from a vector a part of another one.
fn subtract(shape: &mut [Complex64], other: &[Complex64], part: Complex64) {
    shape
        .iter_mut()
        .zip(other)
        .for_each(|(x, y)| *x -= part * y);
}
