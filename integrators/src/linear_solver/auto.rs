//! The default solver.

use pullback_manifold::sparse::BlockPattern;

use super::{BlockLu, FaerLdlt, FaerLu, LinearError, LinearSolver, MatrixSymmetry};

/// [`BlockLu`] or [`FaerLdlt`], whichever suits the matrix; [`FaerLu`] if none does or if it fails.
///
/// A matrix is called singular only if both agree.
pub struct AutoSolver {
    pattern: BlockPattern,
    symmetry: MatrixSymmetry,
    /// The solver that suits the matrix, to be tried first.
    preferred: Option<(SolverKind, Box<dyn LinearSolver>)>,
    /// Made when it is first needed.
    lu: Option<FaerLu>,
    /// The same, for signs alone.
    signs: Option<FaerLdlt>,
    /// The solver that holds the factors.
    active: Option<SolverKind>,
    /// Number of factorisations in a row in which the chosen solver failed and the LU did not.
    failures: usize,
}

/// One of the solvers behind [`AutoSolver`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SolverKind {
    /// [`BlockLu`].
    Block,
    /// [`FaerLdlt`].
    Ldlt,
    /// [`FaerLu`].
    Lu,
}

/// Number of failures in a row after which the chosen solver is not used any more.
const FAILURES: usize = 3;

impl AutoSolver {
    /// Chooses the solver, which finds the structure of its factors.
    ///
    /// # Errors
    /// [`LinearError::Library`].
    pub fn new(pattern: &BlockPattern, symmetry: MatrixSymmetry) -> Result<Self, LinearError> {
        let chosen: Option<(_, Box<dyn LinearSolver>)> = match BlockLu::new(pattern, symmetry) {
            Ok(block) if block.suits() => Some((SolverKind::Block, Box::new(block))),
            Ok(_) | Err(LinearError::Fill { .. }) => match symmetry {
                MatrixSymmetry::Symmetric => {
                    Some((SolverKind::Ldlt, Box::new(FaerLdlt::new(pattern)?)))
                }
                MatrixSymmetry::General => None,
            },
            Err(error) => return Err(error),
        };
        Ok(Self {
            pattern: pattern.clone(),
            symmetry,
            preferred: chosen,
            lu: None,
            signs: None,
            active: None,
            failures: 0,
        })
    }

    /// The solver that made the last factorisation.
    pub fn active(&self) -> Option<SolverKind> {
        self.active
    }

    /// The solver that holds the factors.
    fn active_solver(&mut self) -> Option<&mut dyn LinearSolver> {
        match (self.active?, &mut self.preferred) {
            (SolverKind::Lu, _) => self.lu.as_mut().map(|lu| lu as &mut dyn LinearSolver),
            (_, Some((_, chosen))) => Some(&mut **chosen),
            (_, None) => None,
        }
    }

    /// Factorises by the chosen solver, or by the LU if that fails.
    fn factorise_by(
        &mut self,
        values: &[f64],
        factorise: impl FnOnce(&mut dyn LinearSolver) -> Result<(), LinearError>,
    ) -> Result<(), LinearError> {
        self.active = None;
        let Some((kind, chosen)) = (self.preferred.as_mut()).filter(|_| self.failures < FAILURES)
        else {
            return self.fall_back(values);
        };
        match factorise(&mut **chosen) {
            Ok(()) => {
                self.failures = 0;
                self.active = Some(*kind);
                Ok(())
            }
            Err(
                LinearError::VanishingPivot { .. }
                | LinearError::Singular { .. }
                | LinearError::Growth { .. }
                | LinearError::Residual { .. },
            ) => {
                self.fall_back(values)?;
                self.failures += 1;
                Ok(())
            }
            Err(error) => Err(error),
        }
    }

    fn fall_back(&mut self, values: &[f64]) -> Result<(), LinearError> {
        let lu = match &mut self.lu {
            Some(lu) => lu,
            none => none.insert(FaerLu::new(&self.pattern)?),
        };
        lu.factorise(values)?;
        self.active = Some(SolverKind::Lu);
        Ok(())
    }
}

impl LinearSolver for AutoSolver {
    fn factorise(&mut self, values: &[f64]) -> Result<(), LinearError> {
        self.factorise_by(values, |chosen| chosen.factorise(values))
    }

    fn solve(&mut self, values: Option<&[f64]>, b: &mut [f64]) -> Result<(), LinearError> {
        let solver = self.active_solver().ok_or(LinearError::NotReady)?;
        match (solver.solve(values, b), values) {
            // `b` is untouched when a solve fails.
            (Err(LinearError::Residual { .. }), Some(known))
                if self.active != Some(SolverKind::Lu) =>
            {
                self.fall_back(known)?;
                self.solve(values, b)
            }
            (result, _) => result,
        }
    }

    fn factorise_and_solve(&mut self, values: &[f64], b: &mut [f64]) -> Result<(), LinearError> {
        self.factorise_by(values, |chosen| chosen.factorise_and_solve(values, b))?;
        match self.active {
            Some(SolverKind::Lu) => self.solve(Some(values), b),
            _ => Ok(()),
        }
    }

    /// An LU with row interchanges does not provide the signs: they need an LDLᵀ factorisation.
    fn negative_pivots(&mut self, values: &[f64]) -> Option<usize> {
        if self.active? != SolverKind::Lu || self.symmetry == MatrixSymmetry::General {
            return self.active_solver()?.negative_pivots(values);
        }
        let signs = match &mut self.signs {
            Some(signs) => signs,
            none => none.insert(FaerLdlt::for_signs(&self.pattern).ok()?),
        };
        signs.signs(values)
    }
}
