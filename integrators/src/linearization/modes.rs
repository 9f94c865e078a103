//! Frequencies, damping and shapes of the modes of a linearised system.

use super::finish::Finish;
use super::search::Search;
use super::shift_invert::Order;
use super::{Linearized, check_count};
use crate::linear_solver::LinearError;
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
    /// All with |λ| in this range, its ends included.
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

impl Selection {
    /// Largest number of modes.
    pub(super) fn most(&self) -> usize {
        match *self {
            Self::Nearest { count, .. } => count,
            Self::Range(_) => usize::MAX,
        }
    }
}

impl ModeOptions {
    /// The lowest modes, with the damping of the system.
    pub fn lowest(count: usize) -> Self {
        Self {
            selection: Selection::Nearest { count, omega: 0.0 },
            undamped: false,
        }
    }

    /// Order of the eigenvalue problem.
    pub(super) fn order(&self, lin: &Linearized) -> Order {
        match self.undamped || lin.C.iter().all(|c| *c == 0.0) {
            true => Order::Squares,
            false => Order::Quadratic,
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
    /// Number of eigenvalues in the region searched, by Sylvester's law of inertia: all of them were found, but for more copies
    /// of the last one than requested.
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
        "{converged} modes converged in a Krylov subspace of dimension {dimension}, and others as near may be missing; ask for \
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
    let (undamped, mut factorisations) = undamped(lin, options, observer)?;
    let rigid: Vec<Mode> = match options.selection {
        Selection::Nearest { omega, .. } if omega > 0.0 => Vec::new(),
        _ => (undamped.iter().filter(|mode| mode.omega() == 0.0))
            .cloned()
            .collect(),
    };
    let mut sought = *options;
    // More than there are.
    let most = options.selection.most().min(2 * lin.dim() + 1);
    if let Selection::Nearest { count, .. } = &mut sought.selection {
        *count = most + rigid.len();
    }
    loop {
        let search = Search::new(lin, &sought, &undamped)?;
        let (order, symmetric) = (options.order(lin), search.is_symmetric());
        let found = search.run(observer)?;
        factorisations += found.factorisations;
        let finish = Finish::new(lin, order, symmetric, found.scales);
        let vectors = found.vectors.len();
        let mut modes = rigid.clone();
        for (vector, eigenvalue) in found.vectors {
            for mode in finish.modes(vector, eigenvalue) {
                modes.extend(finish.apart(&modes, mode, eigenvalue));
            }
        }
        modes.sort_by(|a, b| a.omega().total_cmp(&b.omega()));
        // Modes at rest that were found twice leave too few others.
        if let Selection::Nearest { count, .. } = &mut sought.selection
            && modes.len() < most
            && vectors == *count
        {
            *count += most - modes.len();
            continue;
        }
        modes.truncate(options.selection.most());
        return Ok(Modes {
            modes,
            counted: found.counted,
            complete: found.complete,
            factorisations,
        });
    }
}

/// Of a system with damping the modes without, if they can be counted, and the number of factorisations. Rigid ones are modes
/// with damping, too.
fn undamped(
    lin: &Linearized,
    options: &ModeOptions,
    observer: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<(Vec<Mode>, usize), ModesError> {
    let countable = lin.is_symmetric(&lin.K) && lin.is_symmetric(&lin.M);
    if options.order(lin) == Order::Squares || !countable {
        return Ok((Vec::new(), 0));
    }
    let undamped = ModeOptions {
        undamped: true,
        ..*options
    };
    match modes_while(lin, &undamped, observer) {
        Ok(found) => Ok((found.modes, found.factorisations)),
        Err(ModesError::Interrupted) => Err(ModesError::Interrupted),
        Err(_) => Ok((Vec::new(), 0)),
    }
}

fn check(lin: &Linearized, options: &ModeOptions) -> Result<(), ModesError> {
    let refuse = |text: String| Err(ModesError::Options(text));
    match options.selection {
        Selection::Nearest { count: 0, .. } => return check_count(0),
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
