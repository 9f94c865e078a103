//! Frequencies, damping and shapes of the modes of a linearised system.

#![allow(non_snake_case)]

use super::Linearized;
use super::krylov::{add, dot};
use super::search::{Parts, Search};
use super::shift_invert::Order;
use crate::linear_solver::LinearError;
use crate::linear_solver::scaling::{self, for_each};
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use thiserror::Error;

/// Which modes to find.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Selection {
    /// Those nearest to a circular frequency, in the order of its distance; the lowest ones for zero.
    Nearest {
        /// Number of modes.
        count: usize,
        /// Circular frequency ω.
        omega: f64,
    },
    /// All with a circular frequency in this range. Unstable modes without oscillation have none.
    Range([f64; 2]),
}

/// Options of [`modes`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeOptions {
    /// Which modes to find.
    pub selection: Selection,
    /// Whether C, damping and gyroscopic terms, is left out.
    pub undamped: bool,
}

impl ModeOptions {
    /// The lowest modes, with the damping of the system.
    pub fn lowest(count: usize) -> Self {
        Self {
            selection: Selection::Nearest { count, omega: 0.0 },
            undamped: false,
        }
    }
}

/// A mode: δq = Re(φ e^(λ t)).
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    /// λ, with Im λ ≥ 0: of a conjugate pair, one. A real λ > 0 is a mode that grows without oscillation.
    pub eigenvalue: Complex64,
    /// φ, coordinate by coordinate, with φᴴ M φ = 1 and its largest component real and positive; a shape without mass
    /// has a largest component of one.
    pub shape: Vec<Complex64>,
    /// Length of (K + λ C + λ² M) φ, relative to the sum of the three terms' bounds, in scaled coordinates.
    pub residual: f64,
}

impl Mode {
    /// Circular frequency |λ|: of the undamped vibration, if the mode is one.
    pub fn omega(&self) -> f64 {
        self.eigenvalue.norm()
    }

    /// Frequency of the oscillation, Im λ / 2π.
    pub fn frequency(&self) -> f64 {
        self.eigenvalue.im / TAU
    }

    /// Damping ratio −Re λ / |λ|, from −1 (grows) to 1 (decays without oscillation); zero for λ = 0.
    pub fn damping_ratio(&self) -> f64 {
        match self.omega() {
            0.0 => 0.0,
            // No negative zero.
            omega => 0.0 - self.eigenvalue.re / omega,
        }
    }
}

/// Modes of a system, and how many there are.
#[derive(Clone, Debug, PartialEq)]
pub struct Modes {
    /// The modes, by growing |λ|.
    pub modes: Vec<Mode>,
    /// Number of eigenvalues in the region searched, by Sylvester's law of inertia: all of them were found.
    /// `None` for a problem with damping or with matrices that are not symmetric, where no such count exists.
    pub counted: Option<usize>,
    /// Whether the system has no other modes.
    pub complete: bool,
    /// Number of factorisations.
    pub factorisations: usize,
}

/// Error of [`modes`].
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ModesError {
    /// The options have no meaning.
    #[error("{0}")]
    Options(String),
    /// No coordinate has mass.
    #[error(
        "no coordinate has mass: there are no vibrations. Give sections or bodies their inertia"
    )]
    NoMass,
    /// A coordinate with a negative mass.
    #[error("the mass of {name} is negative ({mass:.3e})")]
    NegativeMass {
        /// The coordinate.
        name: String,
        /// Its entry on the diagonal of M.
        mass: f64,
    },
    /// The shifted stiffness cannot be factorised, whatever the shift.
    #[error("K − σ M is singular for every shift σ: {error}; the coordinate is {name}")]
    Singular {
        /// Error of the last factorisation.
        error: LinearError,
        /// A coordinate without mass and stiffness.
        name: String,
    },
    /// The linear solver failed.
    #[error(transparent)]
    Linear(#[from] LinearError),
    /// The iteration did not converge.
    #[error(
        "{converged} modes converged in a Krylov subspace of dimension {dimension}, fewer than requested; ask for \
         fewer modes, or for a narrower range"
    )]
    NotConverged {
        /// Number of converged modes.
        converged: usize,
        /// Dimension of the subspace.
        dimension: usize,
    },
    /// The observer ended the search.
    #[error("interrupted")]
    Interrupted,
}

/// The modes of a linearised system.
///
/// Without damping, of K φ = ω² M φ. With it, of (K + λ C + λ² M) φ = 0, which holds for gyroscopic terms
/// as well. Symmetric problems are counted by Sylvester's law of inertia, and repeated frequencies are
/// found as often as they occur.
///
/// # Errors
/// [`ModesError`].
pub fn modes(lin: &Linearized, options: &ModeOptions) -> Result<Modes, ModesError> {
    modes_while(lin, options, &mut |_| ControlFlow::Continue(()))
}

/// As [`modes`], with an observer that is told the dimension of the Krylov subspace and may end the search.
///
/// # Errors
/// [`ModesError`].
pub fn modes_while(
    lin: &Linearized,
    options: &ModeOptions,
    observer: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<Modes, ModesError> {
    check(lin, options)?;
    let search = Search::new(lin, options)?;
    let (order, symmetric) = search.kind();
    let found = search.run(observer)?;
    let finish = Finish::new(lin, order, symmetric, found.scales);
    let mut modes: Vec<Mode> = Vec::with_capacity(found.vectors.len());
    for (vector, eigenvalue) in found.vectors {
        let mode = finish.mode(&vector, eigenvalue);
        if !finish.repeats(&modes, &mode) {
            modes.push(mode);
        }
    }
    modes.sort_by(|a, b| a.omega().total_cmp(&b.omega()));
    Ok(Modes {
        modes,
        counted: found.counted,
        complete: found.complete,
        factorisations: found.factorisations,
    })
}

fn check(lin: &Linearized, options: &ModeOptions) -> Result<(), ModesError> {
    let refuse = |text: String| Err(ModesError::Options(text));
    match options.selection {
        Selection::Nearest { count: 0, .. } => {
            return refuse("the number of modes must be at least 1".to_owned());
        }
        Selection::Nearest { omega, .. } if !(omega >= 0.0 && omega.is_finite()) => {
            return refuse(format!(
                "the circular frequency must be zero or positive, and is {omega}"
            ));
        }
        Selection::Range([from, to]) if !(0.0 <= from && from < to && to.is_finite()) => {
            return refuse(format!(
                "a range of circular frequencies grows from zero or above; it is from {from} to {to}"
            ));
        }
        _ => {}
    }
    if lin.M.iter().all(|m| *m == 0.0) {
        return Err(ModesError::NoMass);
    }
    let negative = |(_, k): &(usize, usize)| lin.M[*k] < 0.0;
    if let Some((i, k)) = lin.pattern.diagonal().enumerate().find(negative) {
        return Err(ModesError::NegativeMass {
            name: lin.names[i].clone(),
            mass: lin.M[k],
        });
    }
    Ok(())
}

/// Rounding errors of φᵀ K φ in units of those of its terms.
pub(super) const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Makes modes of eigenvectors: their eigenvalues, scale and residual.
struct Finish<'a> {
    lin: &'a Linearized,
    order: Order,
    symmetric: bool,
    scales: Vec<f64>,
    norms: [f64; 3],
}

impl<'a> Finish<'a> {
    /// `scales` make the shifted matrix one of entries of order one.
    fn new(lin: &'a Linearized, order: Order, symmetric: bool, scales: Vec<f64>) -> Self {
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
    fn mode(&self, shape: &Parts, found: Complex64) -> Mode {
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
        let eigenvalue = match (self.order, self.symmetric) {
            (Order::Quadratic, _) => found,
            // The quotient's error is the square of the eigenvector's.
            (Order::Squares, true) => Complex64::from(-form(&images[0]) / mass).sqrt(),
            (Order::Squares, false) => (-found).sqrt(),
        };
        let eigenvalue = match eigenvalue {
            value if self.is_rigid(shape, value.norm(), [form(&images[0]), mass]) => {
                Complex64::ZERO
            }
            value if value.im < 0.0 => -value,
            value => value,
        };
        // No sign of a damping that is a rounding error.
        let eigenvalue = match eigenvalue {
            Complex64 { re, im } if re.abs() <= ROUNDING * im => Complex64::new(0.0, im),
            value => value,
        };
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

    /// Whether a mode at rest was found before: with velocities, λ = 0 occurs twice for each.
    fn repeats(&self, modes: &[Mode], mode: &Mode) -> bool {
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
        for_each(&self.lin.pattern, &self.lin.K, |r, c, K| {
            sum += K.abs() * sizes[r] * sizes[c];
        });
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
