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
use super::{LinearError, LinearSolver, MatrixSymmetry, check_length, ready};

/// Number of block updates beyond which [`BlockLu`] refuses to analyse: several seconds of 6 × 6 ones.
const MAX_UPDATES: usize = 20_000_000;

/// Sparse LU of dense blocks; see the module's source for method and criteria.
#[derive(Default)]
pub struct BlockLu {
    ready: Option<Factors>,
    factorised: bool,
}

impl BlockLu {
    /// A solver without a pattern.
    pub fn new() -> Self {
        Self::default()
    }

    /// Whether this solver is likely faster than a general sparse solver on the analysed pattern.
    ///
    /// Estimates in nanoseconds, fitted to chains and grids of six-dof nodes. The general LU costs
    /// 30 per entry of the matrix and then does 8 operations per nanosecond (of ours: its order
    /// fills in more, but its dense kernels are better); the general LDLᵀ, for symmetric
    /// matrices, costs 15 per entry and does 30 operations.
    pub fn suits(&self) -> bool {
        let Some(ready) = &self.ready else {
            return false;
        };
        let (entry, rate) = match ready.symbolic.symmetry {
            MatrixSymmetry::General => (30.0, 8.0),
            MatrixSymmetry::Symmetric => (15.0, 30.0),
        };
        let general = entry * ready.pattern.len() as f64 + ready.symbolic.flops / rate;
        ready.symbolic.nanoseconds() < general
    }

    /// Factorises, and substitutes a right-hand side through the lower factor at the same time.
    fn factorise_with(&mut self, values: &[f64], b: Option<&[f64]>) -> Result<(), LinearError> {
        self.factorised = false;
        let ready = ready(&mut self.ready, "factorise")?;
        check_length("matrix", ready.pattern.len(), values.len())?;
        if let Some(b) = b {
            check_length("right-hand side", ready.pattern.dim(), b.len())?;
        }
        self.factorised = ready.factorise(values, false, b)? || {
            ready.equilibrate(values)?;
            ready.factorise(values, true, b)?
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
    fn analyse(
        &mut self,
        pattern: &BlockPattern,
        symmetry: MatrixSymmetry,
    ) -> Result<(), LinearError> {
        self.ready = None;
        self.factorised = false;
        let symbolic = Symbolic::new(pattern, symmetry, MAX_UPDATES)?;
        self.ready = Some(Factors::new(pattern, symbolic));
        Ok(())
    }

    fn factorise(&mut self, values: &[f64]) -> Result<(), LinearError> {
        self.factorise_with(values, None)
    }

    fn solve(&mut self, values: Option<&[f64]>, b: &mut [f64]) -> Result<(), LinearError> {
        let Some(ready) = self.ready.as_mut().filter(|_| self.factorised) else {
            return Err(LinearError::NotReady { call: "solve" });
        };
        check_length("right-hand side", ready.pattern.dim(), b.len())?;
        ready.gather(b);
        ready.substitute();
        if let Some(values) = values {
            check_length("matrix", ready.pattern.len(), values.len())?;
            ready.refine(values, b)?;
        }
        ready.scatter(b);
        Ok(())
    }

    fn factorise_and_solve(&mut self, values: &[f64], b: &mut [f64]) -> Result<(), LinearError> {
        self.factorise_with(values, Some(b))?;
        let ready = ready(&mut self.ready, "solve")?;
        ready.substitute_back();
        ready.refine(values, b)?;
        ready.scatter(b);
        Ok(())
    }

    /// From the signs of the pivots, at no cost; see the source of `inertia`.
    fn negative_pivots(&mut self, _: &[f64]) -> Option<usize> {
        let ready = self.ready.as_ref().filter(|_| self.factorised)?;
        (ready.symbolic.symmetry == MatrixSymmetry::Symmetric).then(|| ready.negative_pivots())
    }
}
