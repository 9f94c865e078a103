//! Linear equations of motion about a state, and their modes.
//!
//! ```text
//! M δq̈ + C δq̇ + K δq = (∂r/∂u) δu
//! ```
//!
//! K, C and M are the exact tangents of the system at the state: at rest, in a motion, or in a relative
//! equilibrium, where centrifugal and gyroscopic terms are part of K and C. Constraints are linearised with
//! them. Maps leave independent coordinates, and multipliers are unknowns without mass, so that the modes
//! are those in the null space of h_x in both cases.
//!
//! - [`linearize`] evaluates the matrices.
//! - [`modes`] finds frequencies, damping and shapes by shift and invert, counted by Sylvester's law of
//!   inertia.
//! - [`buckling`] finds critical loads by linear extrapolation of the static tangent.
//! - [`campbell`] follows modes over the speed of a rotation.
//! - [`stability_limit`] finds the load at which a mode begins to grow, such as flutter.
//! - [`SteadyMotion`] makes the equilibrium relative to a rotating frame a problem of statics.

mod buckling;
mod campbell;
mod differences;
mod finish;
mod krylov;
mod modes;
mod search;
mod shift_invert;
mod stability;
mod state_space;
mod steady;

pub use buckling::{BucklingError, BucklingMode, buckling, buckling_while};
pub use campbell::{CampbellDiagram, CampbellError, CampbellOptions, campbell};
pub(crate) use krylov::Krylov;
pub use modes::{Mode, ModeOptions, Modes, ModesError, Selection, modes, modes_while};
pub use stability::{StabilityError, StabilityLimit, stability_limit};
pub use state_space::{OutputDerivatives, StateSpace, StateSpaceError, output_derivatives};
pub use steady::SteadyMotion;

use crate::abilities::{energies, events};
use crate::rounding::{EXACT, TERMS, is_exact, is_rounding, largest, rounding_errors};
use finish::ROUNDING;
use nalgebra::ComplexField;
use num_complex::Complex64;
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::{Evaluation, Point, Quantity, System, SystemError, Weights};
use std::cell::LazyCell;
use thiserror::Error;

/// The linear equations of motion of a system about a state.
#[derive(Clone, Debug)]
pub struct Linearized {
    /// Pattern of the matrices, with the kinds of the coordinates.
    pub pattern: BlockPattern,
    /// K = −∂r/∂q, values in the pattern; zero where nothing but rounding errors is left, as in the row of a free hinge.
    pub K: Vec<f64>,
    /// C = −∂r/∂q̇.
    pub C: Vec<f64>,
    /// M = −∂r/∂q̈.
    pub M: Vec<f64>,
    /// Column by column ∂r/∂u of the inputs of the system.
    pub r_u: Vec<Vec<f64>>,
    /// Names of the coordinates.
    pub names: Vec<String>,
}

/// Error of a linearisation.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LinearizationError {
    /// The system cannot be evaluated at the state.
    #[error(transparent)]
    System(#[from] SystemError),
    /// The state satisfies no equations of motion.
    #[error(
        "the state is not in balance: the {quantity} of {name} is {residual:.3e}, which is {ratio:.1e} of the \
         largest {quantity} of loads, reactions and inertia; solve for equilibrium, or for consistent accelerations, first"
    )]
    Unbalanced {
        /// The coordinate with the largest residual.
        name: String,
        /// Force, moment or residual.
        quantity: &'static str,
        /// Its residual.
        residual: f64,
        /// The residual relative to the largest force or moment of loads, reactions and inertia.
        ratio: f64,
    },
}

/// Refuses a search for no modes.
fn check_count(count: usize) -> Result<(), ModesError> {
    match count {
        0 => Err(ModesError::Options(
            "the number of modes must be at least 1".to_owned(),
        )),
        _ => Ok(()),
    }
}

/// Largest residual of a state in balance, relative to the forces.
const BALANCED: f64 = 1e-4;

/// Linearises a system about a state that satisfies its equations of motion.
///
/// At a static point, which has no velocities, K is the static tangent, and C and M are those at rest.
///
/// # Errors
/// [`LinearizationError`] if the system cannot be evaluated, or the state is not in balance.
pub fn linearize(system: &mut dyn System, at: Point<'_>) -> Result<Linearized, LinearizationError> {
    let r_u = differences::input_columns(system, at)?;
    let (mut lin, r) = equations(system, at)?;
    lin.r_u = r_u;
    let n = lin.dim();
    let (mut sizes, mut floor) = (vec![0.0; n], vec![0.0; n]);
    if !is_rounding(system, &lin.K, at.q, &r, [&mut sizes, &mut floor]) {
        let scales = system.scales();
        let kinetic = energies(system, at)?.map_or(0.0, |energies| energies.kinetic);
        let springs = largest(&lin.pattern, &floor, [0.0; 3]).map(|x| x / f64::EPSILON);
        let errors = rounding_errors(system, &lin.K, at.q, [&mut sizes, &mut floor]);
        // Forces of inertia may cancel each other, as those of a top do; loads below the rounding errors of springs count as these.
        let rounding = Quantity::ALL.map(|quantity| match quantity {
            Quantity::Other => TERMS * errors[quantity.index()],
            _ => (EXACT * kinetic / quantity.size(scales.length))
                .max(BALANCED * errors[quantity.index()]),
        });
        lin.check_balance(&r, at, [scales.measures(), springs, rounding])?;
    }
    Ok(lin)
}

/// The linear equations about a state without inputs, and its residual.
fn equations(
    system: &mut dyn System,
    at: Point<'_>,
) -> Result<(Linearized, Vec<f64>), LinearizationError> {
    let (n, len) = (system.pattern().dim(), system.pattern().len());
    let mut r = vec![0.0; n];
    let mut tangent = |at: Point<'_>, weights: Weights| -> Result<Vec<f64>, SystemError> {
        let mut S = vec![0.0; len];
        system.evaluate(at, Evaluation::with_tangent(&mut r, weights, &mut S))?;
        Ok(S)
    };
    let M = tangent(at, Weights::MASS)?;
    let C = tangent(at, Weights::DAMPING)?;
    let K = tangent(at, Weights::STATIC)?;
    let finite = |values: &Vec<f64>| values.iter().all(|x| x.is_finite());
    if ![&r, &K, &C, &M].into_iter().all(finite) {
        let what = "linear equations".to_owned();
        return Err(SystemError::NotFinite { what }.into());
    }
    let mut lin = Linearized {
        r_u: Vec::new(),
        pattern: system.pattern().clone(),
        K,
        C,
        M,
        names: (0..n).map(|i| system.name(i)).collect(),
    };
    lin.drop_rounding();
    Ok((lin, r))
}

impl Linearized {
    /// Number of coordinates.
    pub fn dim(&self) -> usize {
        self.pattern.dim()
    }

    /// Refuses residuals that are neither small beside loads, reactions and forces of inertia, without any of these beside
    /// forces of springs, nor rounding errors.
    fn check_balance(
        &self,
        r: &[f64],
        at: Point<'_>,
        [loads, springs, rounding]: [[f64; 3]; 3],
    ) -> Result<(), LinearizationError> {
        let mut inertia = vec![0.0; self.dim()];
        // Statics has no rates.
        let rates = [(&self.M, at.a), (&self.C, at.v)].into_iter();
        for (matrix, rates) in rates.filter(|(_, rates)| !rates.is_empty()) {
            let entries = self.pattern.triplets(matrix);
            entries.for_each(|(r, c, x)| inertia[r] += (x * rates[c]).abs());
        }
        let coordinates = self.pattern.coordinates();
        let worst = largest(&self.pattern, r, [0.0; 3]);
        let measures = largest(&self.pattern, &inertia, loads);
        for quantity in Quantity::ALL {
            let k = quantity.index();
            let residual = worst[k];
            let measure = match measures[k] > 0.0 {
                true => measures[k],
                false => springs[k],
            };
            if residual > (BALANCED * measure).max(rounding[k]) {
                let at =
                    |i: &usize| coordinates[*i].quantity == quantity && r[*i].abs() >= residual;
                let name = (0..r.len()).find(at).map(|i| self.names[i].clone());
                return Err(LinearizationError::Unbalanced {
                    name: name.unwrap_or_default(),
                    quantity: quantity.conjugate(),
                    residual,
                    ratio: residual / measure,
                });
            }
        }
        Ok(())
    }

    /// A x for a matrix with these values.
    fn product<T>(&self, values: &[f64], x: &[T]) -> Vec<T>
    where
        T: Copy + ComplexField<RealField = f64>,
    {
        let mut y = vec![T::zero(); x.len()];
        self.pattern.multiply_add(1.0, values, x, &mut y);
        y
    }

    /// Makes the rows and columns of K of coordinates without stiffness zero where they are nothing but rounding errors, as those
    /// of the free hinge of a blade.
    fn drop_rounding(&mut self) {
        let errors = self.rounding_errors(&self.K);
        let diagonal = self.pattern.diagonal().zip(&errors);
        let is_free = |(k, error): (usize, &f64)| self.K[k].abs() <= error * error;
        let free: Vec<bool> = diagonal.map(is_free).collect();
        let entries = self.pattern.triplets(&self.K);
        let known = entries.map(|(r, c, x)| {
            let is_rounding = (free[r] || free[c]) && x.abs() <= errors[r] * errors[c];
            if is_rounding { 0.0 } else { x }
        });
        self.K = known.collect();
    }

    /// Rounding errors of the entries of a matrix, each the product of those of its row and column.
    ///
    /// An entry is a sum over all that moves with its coordinate, as a blade with its hinge, although nothing may be left of it.
    fn rounding_errors(&self, values: &[f64]) -> Vec<f64> {
        let diagonal: Vec<[f64; 2]> = (self.pattern.diagonal())
            .map(|k| [values[k].abs(), self.M[k]])
            .collect();
        let mut squares = vec![0.0; self.dim()];
        for (r, c, m) in self.pattern.triplets(&self.M) {
            let [value, mass] = diagonal[c];
            if mass > 0.0 {
                squares[r] += (value * (m / mass).powi(2)).powi(2);
            }
        }
        let root = |square: f64| (ROUNDING * square.sqrt()).sqrt();
        squares.into_iter().map(root).collect()
    }

    /// Whether a matrix is symmetric but for rounding errors.
    fn is_symmetric(&self, values: &[f64]) -> bool {
        let p = &self.pattern;
        let errors = LazyCell::new(|| {
            let mut largest = vec![0.0_f64; self.dim()];
            let entries = p.triplets(values);
            entries.for_each(|(r, _, value)| largest[r] = largest[r].max(value.abs()));
            let rows = largest.iter().zip(self.rounding_errors(values));
            let error = |(x, error): (&f64, f64)| (SYMMETRIC * x).sqrt().max(error);
            rows.map(error).collect::<Vec<f64>>()
        });
        let mut symmetric = true;
        for j in 0..p.blocks() {
            let columns = p.unknowns(j);
            for (i, range) in p.column(j).filter(|(i, _)| *i >= j) {
                let rows = p.unknowns(i);
                let Some(other) = p.find(j, i) else {
                    return false;
                };
                let entries = values[range].chunks_exact(rows.len().max(1));
                for (c, column) in entries.enumerate() {
                    for (r, a) in column.iter().enumerate() {
                        let b = values[other + c + r * columns.len()];
                        if *a != b {
                            let error = errors[rows.start + r] * errors[columns.start + c];
                            symmetric &= (a - b).abs() <= error;
                        }
                    }
                }
            }
        }
        symmetric
    }
}

/// Whether a point is an equilibrium but for rounding errors. It is not solved for then: at a critical speed its stiffness
/// is singular.
fn is_balanced(system: &mut dyn System, at: Point<'_>) -> bool {
    let mut r = vec![0.0; at.q.len()];
    let evaluated = system.evaluate(at, Evaluation::residual(&mut r));
    evaluated.is_ok() && is_exact(system, &r)
}

/// xᴴ y.
fn inner_product(x: &[Complex64], y: &[Complex64]) -> Complex64 {
    x.iter().zip(y).map(|(x, y)| x.conj() * y).sum()
}

/// Largest difference of a pair of entries that counts as rounding, relative to their rows.
const SYMMETRIC: f64 = 1e-11;
