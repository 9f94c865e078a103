//! Linear systems with block-sparse matrices: a solver is made once for a pattern, factorises often, solves more often.
//!
//! | solver | for |
//! |---|---|
//! | [`AutoSolver`] | general use: [`BlockLu`] if it suits, else faer |
//! | [`BlockLu`] | chains, trees, rings, small frames: blocks of a few unknowns, little fill |
//! | [`FaerLu`] | matrices that need row interchanges between blocks, or that fill in a lot |
//! | [`FaerLdlt`] | symmetric matrices that fill in a lot and need no interchanges |
//!
//! All of them work on the symmetrically scaled matrix `S A S`, `S` a diagonal of powers of two
//! ([`scaling`]), so that "small" means the same for a metre and for a radian. The relative
//! residual that every solve checks is that of the scaled system,
//!
//! ```text
//! max|b - A x| / (‖A‖ max|x| + max|b|)
//! ```
//!
//! with `‖A‖` a bound on the spectral norm (block rows of Frobenius norms). A small residual means
//! that the solution solves a *nearby* system; the error of the solution is another matter, and
//! large for an ill-conditioned structure (a long cantilever).

// `!(a <= b)` also rejects NaN.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

mod auto;
mod block;
mod columns;
mod factors;
mod faer;
mod inertia;
mod kernels;
mod null_vector;
mod ordering;
pub mod scaling;
mod solution;
mod symbolic;

pub use auto::{AutoSolver, SolverKind};
pub use block::BlockLu;
pub use faer::{FaerLdlt, FaerLu};
pub use null_vector::{NullVector, null_vector};

use thiserror::Error;

/// Known structure of the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatrixSymmetry {
    /// Nothing; only the pattern is symmetric.
    General,
    /// The values are symmetric, though possibly indefinite. Of a pair of blocks only one is read.
    Symmetric,
}

/// A direct solver for matrices of one pattern.
pub trait LinearSolver: Send {
    /// Factorises the matrix with these values.
    fn factorise(&mut self, values: &[f64]) -> Result<(), LinearError>;

    /// Replaces `b` by the solution of `A x = b`, refined and checked against the `values` of the
    /// last factorisation, so that no solver keeps a copy. Without them (a simplified Newton step,
    /// when the matrix is that of the next iterate already) the solution may be unchecked.
    fn solve(&mut self, values: Option<&[f64]>, b: &mut [f64]) -> Result<(), LinearError>;

    /// Both at once, refined and checked: a Newton iteration. A solver may use the factors while
    /// they are in cache. If there is no solution, `b` is unchanged.
    fn factorise_and_solve(&mut self, values: &[f64], b: &mut [f64]) -> Result<(), LinearError> {
        self.factorise(values)?;
        self.solve(Some(values), b)
    }

    /// Number of negative eigenvalues of the last factorised matrix, which is symmetric and has
    /// these `values`: in statics the number of unstable directions of an equilibrium. `None` if
    /// unknown, and by default.
    fn negative_pivots(&mut self, values: &[f64]) -> Option<usize> {
        let _ = values;
        None
    }
}

/// Error of a linear solver.
#[derive(Clone, Debug, PartialEq, Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
#[non_exhaustive]
pub enum LinearError {
    /// `solve` without a successful `factorise` before it.
    #[error("no matrix has been factorised")]
    NotReady,
    /// A vector of the wrong length.
    #[error("{what} has {found} entries where the pattern has {expected}")]
    Length {
        what: &'static str,
        expected: usize,
        found: usize,
    },
    /// A value that is infinite or not a number.
    #[error("{what} is not finite at unknown {unknown}")]
    NonFinite {
        /// Matrix, right-hand side or solution.
        what: &'static str,
        /// The first unknown (row) concerned.
        unknown: usize,
    },
    /// An unknown that occurs in no equation.
    #[error("row and column {unknown} of the matrix are zero: nothing holds this unknown")]
    ZeroRow { unknown: usize },
    /// A pivot that has cancelled to rounding errors.
    #[error(
        "pivot of unknown {unknown} is {pivot:.1e} of its original diagonal scale \
         (rounding level {limit:.1e}): a mechanism, or equations that need another order"
    )]
    VanishingPivot {
        /// The unknown whose pivot vanished.
        unknown: usize,
        /// Its pivot in units of the scaled matrix, where rows have entries of order one.
        pivot: f64,
        /// Largest pivot that counts as rounding.
        limit: f64,
    },
    /// Numerically singular: a right-hand side of order one gives a solution beyond all bounds.
    #[error(
        "matrix is singular to working precision (condition at least {condition:.1e}, limit \
         {limit:.1e}); unknown {unknown} moves most"
    )]
    Singular {
        /// The largest component of the mechanism.
        unknown: usize,
        /// Lower bound of the condition number of the scaled matrix.
        condition: f64,
        limit: f64,
    },
    /// Elements grew during elimination until all digits were lost.
    #[error("elements grew by {growth:.1e} up to the pivot of unknown {unknown}")]
    Growth {
        /// The unknown with the largest pivot.
        unknown: usize,
        /// Its pivot relative to the largest entry of the scaled matrix.
        growth: f64,
    },
    /// A residual that iterative refinement did not reduce.
    #[error("relative residual {residual:.1e} of the linear system stays above {limit:.1e}")]
    Residual {
        /// Relative residual, see the module's front page.
        residual: f64,
        limit: f64,
    },
    /// Too much fill for the block solver.
    #[error("elimination fills in more than {limit} block updates")]
    Fill { limit: usize },
    /// The sparse library failed.
    #[error("sparse factorisation failed: {reason}")]
    Library { reason: String },
}

impl LinearError {
    /// The same error with another number of the unknown.
    pub(crate) fn renumbered(mut self, number: impl Fn(usize) -> usize) -> Self {
        match &mut self {
            Self::NonFinite { unknown, .. }
            | Self::ZeroRow { unknown }
            | Self::VanishingPivot { unknown, .. }
            | Self::Singular { unknown, .. }
            | Self::Growth { unknown, .. } => *unknown = number(*unknown),
            Self::NotReady
            | Self::Length { .. }
            | Self::Residual { .. }
            | Self::Fill { .. }
            | Self::Library { .. } => {}
        }
        self
    }
}

/// Refinement starts above this relative residual.
const RESIDUAL_GOAL: f64 = 1e-12;
/// A solution is rejected above this relative residual.
const RESIDUAL_LIMIT: f64 = 1e-9;
/// Largest number of steps of iterative refinement.
const REFINEMENTS: usize = 2;
/// Sizes below this have rounding errors that are not relative to them.
const SUBNORMAL: f64 = f64::MIN_POSITIVE / f64::EPSILON;

/// Refines a solution until its relative residual is small enough or no longer halved; an error if it is too large then.
/// `residual` computes both residuals, `correct` adds the solution for the last one.
fn refine<W>(
    work: &mut W,
    residual: impl Fn(&mut W) -> Result<f64, LinearError>,
    mut correct: impl FnMut(&mut W),
) -> Result<(), LinearError> {
    let mut relative = residual(work)?;
    for _ in 0..REFINEMENTS {
        if relative <= RESIDUAL_GOAL {
            break;
        }
        correct(work);
        let last = std::mem::replace(&mut relative, residual(work)?);
        if relative > 0.5 * last {
            break;
        }
    }
    match relative <= RESIDUAL_LIMIT {
        true => Ok(()),
        false => Err(LinearError::Residual {
            residual: relative,
            limit: RESIDUAL_LIMIT,
        }),
    }
}

/// The relative size of a residual, given the norm of the matrix, the solution and the right-hand side; `None` unless all
/// are finite.
fn relative(norm: f64, [residual, x, rhs]: [&[f64]; 3]) -> Option<f64> {
    let [residual, x, rhs] = [residual, x, rhs].map(max_abs);
    let size = (norm * x + rhs).max(SUBNORMAL);
    (residual <= f64::MAX && size <= f64::MAX).then(|| residual / size)
}

/// Rounding level in a matrix of `blocks` nodes whose scaled rows are of order one.
///
/// Each eliminated node leaves a rounding error of a few ε of its entries in its neighbour. In a
/// floating structure nothing damps these errors (the exact Schur complements carry rigid body
/// motions unchanged), so that they add up like a random walk: the pivot that should vanish is
/// about ε √blocks. A supported structure has smaller pivots only if its condition number exceeds
/// 1/(ε √blocks), when it cannot be told from a mechanism.
pub(crate) fn rounding_level(blocks: usize) -> f64 {
    f64::EPSILON * (16.0 + 4.0 * (blocks as f64).sqrt())
}

pub(crate) fn check_length(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), LinearError> {
    if expected == found {
        Ok(())
    } else {
        Err(LinearError::Length {
            what,
            expected,
            found,
        })
    }
}

/// Largest magnitude; NaN if any entry is NaN.
#[inline(always)]
pub(crate) fn max_abs(x: &[f64]) -> f64 {
    // `f64::max` would drop a NaN; a sum of zero-weighted entries keeps it.
    let (mut largest, mut poison) = ([0.0_f64; 4], [0.0_f64; 4]);
    let (chunks, rest) = x.as_chunks::<4>();
    for chunk in chunks {
        for k in 0..4 {
            let a = chunk[k].abs();
            largest[k] = if a > largest[k] { a } else { largest[k] };
            poison[k] += a * 0.0;
        }
    }
    for &v in rest {
        largest[0] = largest[0].max(v.abs());
        poison[0] += v.abs() * 0.0;
    }
    let poison = poison[0] + poison[1] + poison[2] + poison[3];
    largest[0].max(largest[1]).max(largest[2].max(largest[3])) + poison
}

/// The first entry that is not finite.
pub(crate) fn first_non_finite(x: &[f64]) -> Option<usize> {
    x.iter().position(|v| !v.is_finite())
}
