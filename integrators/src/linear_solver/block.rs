//! Sparse LU of dense blocks.
//!
//! Panels are eliminated in minimum degree order ([`super::ordering`]); rows are interchanged only
//! inside a diagonal block. That is stable for its intended matrices (positive definite ones, and
//! effective tangents dominated by them). All others are detected: by pivots at the rounding level
//! of the scaled matrix, by growth of the pivots, and by the residual of every solution.
//!
//! # When is a pivot zero?
//! The matrix is scaled so that original diagonals are of order one. A pivot below
//! [`rounding_level`](super::rounding_level), about 16 + 4√nodes machine epsilons, has lost every
//! digit to cancellation and is reported as [`LinearError::VanishingPivot`]. An ill-conditioned but
//! supported structure stays clear of that in the order used: eliminated from its free end, a
//! cantilever of any length has pivots of the order of single elements, although its condition
//! number grows with the fourth power of their number. Eliminated from its support, the last pivot
//! falls like 3/N³ relative to an element's and stays above the level up to N of about 10⁴; there
//! the condition number reaches 1/ε and no algorithm can tell the two apart.

use pullback_manifold::sparse::BlockPattern;

use super::factors::Factors;
use super::symbolic::Symbolic;
use super::{LinearError, LinearSolver, MatrixSymmetry, check_length};

/// Number of block updates beyond which [`BlockLu`] refuses a pattern: several seconds of 6 × 6 ones.
const MAX_UPDATES: usize = 20_000_000;

/// Sparse LU of dense blocks; see the module's source for method and criteria.
pub struct BlockLu {
    factors: Factors,
    factorised: bool,
}

impl BlockLu {
    /// Finds the elimination order and the structure of the factors.
    ///
    /// # Errors
    /// [`LinearError::Fill`].
    pub fn new(pattern: &BlockPattern, symmetry: MatrixSymmetry) -> Result<Self, LinearError> {
        let symbolic = Symbolic::new(pattern, symmetry, MAX_UPDATES)?;
        Ok(Self {
            factors: Factors::new(pattern, symbolic),
            factorised: false,
        })
    }

    /// Whether this solver is likely faster than a general sparse solver on its pattern.
    ///
    /// Estimates in nanoseconds, fitted to chains and grids of six-dof nodes. The general LU costs
    /// 30 per entry of the matrix and then does 8 operations per nanosecond (of ours: its order
    /// fills in more, but its dense kernels are better); the general LDLᵀ, for symmetric
    /// matrices, costs 15 per entry and does 30 operations.
    pub fn suits(&self) -> bool {
        let Factors {
            pattern, symbolic, ..
        } = &self.factors;
        let (entry, rate) = match symbolic.symmetry {
            MatrixSymmetry::General => (30.0, 8.0),
            MatrixSymmetry::Symmetric => (15.0, 30.0),
        };
        let general = entry * pattern.len() as f64 + symbolic.flops / rate;
        symbolic.nanoseconds() < general
    }

    /// Factorises, and substitutes a right-hand side through the lower factor at the same time.
    fn factorise_with(&mut self, values: &[f64], b: Option<&[f64]>) -> Result<(), LinearError> {
        self.factorised = false;
        let factors = &mut self.factors;
        check_length("matrix", factors.pattern.len(), values.len())?;
        if let Some(b) = b {
            check_length("right-hand side", factors.pattern.dim(), b.len())?;
        }
        self.factorised = factors.factorise(values, false, b)? || {
            factors.equilibrate(values)?;
            factors.factorise(values, true, b)?
        };
        match self.factorised {
            true => Ok(()),
            // After equilibration no entry exceeds one by much, so a second failure is overflow.
            false => Err(LinearError::NonFinite {
                what: "scaled matrix",
                unknown: 0,
            }),
        }
    }
}

impl LinearSolver for BlockLu {
    fn factorise(&mut self, values: &[f64]) -> Result<(), LinearError> {
        self.factorise_with(values, None)
    }

    fn solve(&mut self, values: Option<&[f64]>, b: &mut [f64]) -> Result<(), LinearError> {
        if !self.factorised {
            return Err(LinearError::NotReady);
        }
        let factors = &mut self.factors;
        check_length("right-hand side", factors.pattern.dim(), b.len())?;
        factors.gather(b);
        factors.substitute();
        if let Some(values) = values {
            check_length("matrix", factors.pattern.len(), values.len())?;
            factors.refine(values, b)?;
        }
        factors.scatter(b);
        Ok(())
    }

    fn factorise_and_solve(&mut self, values: &[f64], b: &mut [f64]) -> Result<(), LinearError> {
        self.factorise_with(values, Some(b))?;
        self.factors.substitute_back();
        self.factors.refine(values, b)?;
        self.factors.scatter(b);
        Ok(())
    }

    /// From the signs of the pivots, at no cost; see the source of `inertia`.
    fn negative_pivots(&mut self, _: &[f64]) -> Option<usize> {
        let is_symmetric = self.factors.symbolic.symmetry == MatrixSymmetry::Symmetric;
        (self.factorised && is_symmetric).then(|| self.factors.negative_pivots())
    }
}
