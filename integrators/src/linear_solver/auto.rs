//! The default solver.

use pullback_manifold::sparse::BlockPattern;

use super::{BlockLu, FaerLdlt, FaerLu, LinearError, LinearSolver, MatrixSymmetry, ready};

/// [`BlockLu`] or [`FaerLdlt`], whichever suits the matrix; [`FaerLu`] if none does or if it fails.
///
/// A matrix is called singular only if both agree.
#[derive(Default)]
pub struct AutoSolver {
    block: BlockLu,
    ldlt: FaerLdlt,
    /// Its factors are for signs alone.
    signs: FaerLdlt,
    lu: FaerLu,
    pattern: Option<BlockPattern>,
    symmetry: MatrixSymmetry,
    chosen: SolverKind,
    /// The solver that holds the factors.
    active: Option<SolverKind>,
    /// Number of factorisations in a row in which the chosen solver failed and the LU did not.
    failures: usize,
}

/// One of the solvers behind [`AutoSolver`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum SolverKind {
    /// [`BlockLu`].
    #[default]
    Block,
    /// [`FaerLdlt`].
    Ldlt,
    /// [`FaerLu`].
    Lu,
}

/// Number of failures in a row after which the chosen solver is not used any more.
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

    /// The solver of a kind.
    fn solver(&mut self, kind: SolverKind) -> &mut dyn LinearSolver {
        match kind {
            SolverKind::Block => &mut self.block,
            SolverKind::Ldlt => &mut self.ldlt,
            SolverKind::Lu => &mut self.lu,
        }
    }

    /// The solver to try first.
    fn first(&mut self) -> Option<&mut dyn LinearSolver> {
        self.active = None;
        let tried = self.chosen != SolverKind::Lu && self.failures < FAILURES;
        tried.then(|| self.solver(self.chosen))
    }

    /// Accepts a factorisation by the chosen solver, or replaces it.
    fn after(
        &mut self,
        result: Result<(), LinearError>,
        values: &[f64],
    ) -> Result<(), LinearError> {
        match result {
            Ok(()) => {
                self.failures = 0;
                self.active = Some(self.chosen);
            }
            Err(
                LinearError::VanishingPivot { .. }
                | LinearError::Singular { .. }
                | LinearError::Growth { .. }
                | LinearError::Residual { .. },
            ) => {
                self.fall_back(values)?;
                self.failures += 1;
            }
            Err(error) => return Err(error),
        }
        Ok(())
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
                    MatrixSymmetry::Symmetric => SolverKind::Ldlt,
                    MatrixSymmetry::General => SolverKind::Lu,
                }
            }
            Err(error) => return Err(error),
        };
        if self.chosen == SolverKind::Ldlt {
            self.ldlt.analyse(pattern, symmetry)?;
        }
        Ok(())
    }

    fn factorise(&mut self, values: &[f64]) -> Result<(), LinearError> {
        match self.first().map(|first| first.factorise(values)) {
            Some(result) => self.after(result, values),
            None => self.fall_back(values),
        }
    }

    fn solve(&mut self, values: Option<&[f64]>, b: &mut [f64]) -> Result<(), LinearError> {
        let Some(active) = self.active else {
            return Err(LinearError::NotReady { call: "solve" });
        };
        match (self.solver(active).solve(values, b), values) {
            // `b` is untouched when a solve fails.
            (Err(LinearError::Residual { .. }), Some(known)) if active != SolverKind::Lu => {
                self.fall_back(known)?;
                self.lu.solve(values, b)
            }
            (result, _) => result,
        }
    }

    fn factorise_and_solve(&mut self, values: &[f64], b: &mut [f64]) -> Result<(), LinearError> {
        let first = self.first();
        match first.map(|first| first.factorise_and_solve(values, b)) {
            Some(result) => self.after(result, values),
            None => self.fall_back(values),
        }?;
        match self.active {
            Some(SolverKind::Lu) => self.lu.solve(Some(values), b),
            _ => Ok(()),
        }
    }

    /// An LU with row interchanges does not provide the signs: they need an LDLᵀ factorisation.
    fn negative_pivots(&mut self, values: &[f64]) -> Option<usize> {
        let active = self.active?;
        if active != SolverKind::Lu || self.symmetry == MatrixSymmetry::General {
            return self.solver(active).negative_pivots(values);
        }
        self.signs.signs(self.pattern.as_ref()?, values)
    }
}
