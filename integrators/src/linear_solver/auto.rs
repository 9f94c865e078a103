//! The default solver.

use pullback_manifold::sparse::BlockPattern;

use super::{BlockLu, FaerCholesky, FaerLu, LinearError, LinearSolver, MatrixSymmetry, ready};

/// [`BlockLu`] if it suits the matrix, faer if not or if it fails.
///
/// A matrix is called singular only if both agree.
#[derive(Default)]
pub struct AutoSolver {
    block: BlockLu,
    cholesky: FaerCholesky,
    lu: FaerLu,
    pattern: Option<BlockPattern>,
    symmetry: MatrixSymmetry,
    chosen: SolverKind,
    /// The solver that holds the factors.
    active: Option<SolverKind>,
    /// Number of factorisations in a row in which the block solver failed and the fallback did not.
    failures: usize,
}

/// One of the solvers behind [`AutoSolver`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum SolverKind {
    /// [`BlockLu`].
    #[default]
    Block,
    /// [`FaerCholesky`].
    Cholesky,
    /// [`FaerLu`].
    Lu,
}

/// Number of failures in a row after which the block solver is not used any more.
const FAILURES: usize = 3;

impl AutoSolver {
    /// A solver without a pattern.
    pub fn new() -> Self {
        Self::default()
    }

    /// The solver that made the last factorisation.
    pub fn active(&self) -> Option<SolverKind> {
        self.active
    }

    /// Whether to try the block solver.
    fn tries_block(&mut self) -> bool {
        self.active = None;
        self.chosen == SolverKind::Block && self.failures < FAILURES
    }

    fn factorise_other(&mut self, values: &[f64]) -> Result<(), LinearError> {
        if self.chosen != SolverKind::Cholesky {
            return self.fall_back(values);
        }
        self.cholesky.factorise(values)?;
        self.active = Some(SolverKind::Cholesky);
        Ok(())
    }

    /// Result of a factorisation by blocks, and the solver that holds the factors.
    fn after_block(
        &mut self,
        result: Result<(), LinearError>,
        values: &[f64],
    ) -> Result<SolverKind, LinearError> {
        match result {
            Ok(()) => {
                self.failures = 0;
                self.active = Some(SolverKind::Block);
                Ok(SolverKind::Block)
            }
            Err(LinearError::Growth { .. }) => self.fall_back(values).map(|()| SolverKind::Lu),
            Err(error @ LinearError::VanishingPivot { unknown, .. }) => {
                match self.fall_back(values) {
                    Ok(()) => {
                        self.failures += 1;
                        Ok(SolverKind::Lu)
                    }
                    // Both agree. The block solver names the last unknown without resistance
                    // (usually at a missing support), if it is part of the mechanism.
                    Err(LinearError::Singular { .. }) if self.lu.mobility(unknown) > 1e-3 => {
                        Err(error)
                    }
                    Err(other) => Err(other),
                }
            }
            Err(other) => Err(other),
        }
    }

    fn fall_back(&mut self, values: &[f64]) -> Result<(), LinearError> {
        let pattern = ready(&mut self.pattern, "factorise")?;
        if !self.lu.is_analysed() {
            self.lu.analyse(pattern, self.symmetry)?;
        }
        self.lu.factorise(values)?;
        self.active = Some(SolverKind::Lu);
        Ok(())
    }
}

impl LinearSolver for AutoSolver {
    fn analyse(
        &mut self,
        pattern: &BlockPattern,
        symmetry: MatrixSymmetry,
    ) -> Result<(), LinearError> {
        *self = Self {
            pattern: Some(pattern.clone()),
            symmetry,
            ..Self::default()
        };
        self.chosen = match self.block.analyse(pattern, symmetry) {
            Ok(()) if self.block.suits() => SolverKind::Block,
            Ok(()) | Err(LinearError::Fill { .. }) => {
                self.block = BlockLu::new();
                match symmetry {
                    MatrixSymmetry::Symmetric => SolverKind::Cholesky,
                    MatrixSymmetry::General => SolverKind::Lu,
                }
            }
            Err(error) => return Err(error),
        };
        if self.chosen == SolverKind::Cholesky {
            self.cholesky.analyse(pattern, symmetry)?;
        }
        Ok(())
    }

    fn factorise(&mut self, values: &[f64]) -> Result<(), LinearError> {
        if !self.tries_block() {
            return self.factorise_other(values);
        }
        let result = self.block.factorise(values);
        self.after_block(result, values).map(|_| ())
    }

    fn solve(&mut self, values: Option<&[f64]>, b: &mut [f64]) -> Result<(), LinearError> {
        match self.active {
            None => Err(LinearError::NotReady { call: "solve" }),
            Some(SolverKind::Cholesky) => self.cholesky.solve(values, b),
            Some(SolverKind::Lu) => self.lu.solve(values, b),
            Some(SolverKind::Block) => match (self.block.solve(values, b), values) {
                // `b` is untouched when a solve fails.
                (Err(LinearError::Residual { .. }), Some(known)) => {
                    self.fall_back(known)?;
                    self.lu.solve(values, b)
                }
                (result, _) => result,
            },
        }
    }

    fn factorise_and_solve(&mut self, values: &[f64], b: &mut [f64]) -> Result<(), LinearError> {
        if !self.tries_block() {
            self.factorise_other(values)?;
            return self.solve(Some(values), b);
        }
        match self.block.factorise_and_solve(values, b) {
            Err(LinearError::Residual { .. }) => {
                self.fall_back(values)?;
                self.lu.solve(Some(values), b)
            }
            result => match self.after_block(result, values)? {
                SolverKind::Block => Ok(()),
                _ => self.lu.solve(Some(values), b),
            },
        }
    }

    /// An LU with row interchanges does not provide the signs: they need an LDLᵀ factorisation.
    fn negative_pivots(&mut self, values: &[f64]) -> Option<usize> {
        match self.active? {
            SolverKind::Block => self.block.negative_pivots(values),
            SolverKind::Cholesky => self.cholesky.negative_pivots(values),
            SolverKind::Lu if self.symmetry == MatrixSymmetry::General => None,
            SolverKind::Lu => {
                if !self.cholesky.is_analysed() {
                    let pattern = self.pattern.as_ref()?;
                    self.cholesky.analyse(pattern, self.symmetry).ok()?;
                }
                self.cholesky.signs(values)
            }
        }
    }
}
