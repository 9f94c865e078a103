//! The general sparse solvers of faer, used in this file only.
//!
//! faer's LU reports success on singular matrices and returns NaN or meaningless numbers. So every
//! factorisation is probed with one right-hand side of ±1-like entries: the largest component of
//! the solution bounds the condition number from below. If it is beyond working precision, the
//! solution is a mechanism, whose largest component is named.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::mat::MatMut;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::linalg::lu::{
    LuRef, LuSymbolicParams, NumericLu, SymbolicLu, factorize_symbolic_lu,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Par, Side};
use pullback_manifold::sparse::BlockPattern;

use super::columns::Columns;
use super::{LinearError, LinearSolver, Symmetry, max_abs, rounding_level};

/// Storage made by `analyse`.
struct Ready<S> {
    columns: Columns,
    symbolic: S,
    memory: MemBuffer,
}

fn structure(columns: &Columns) -> SymbolicSparseColMatRef<'_, usize> {
    let n = columns.scales.len();
    SymbolicSparseColMatRef::new_checked(n, n, &columns.starts, None, &columns.rows)
}

fn library(reason: impl std::fmt::Debug) -> LinearError {
    LinearError::Library {
        reason: format!("{reason:?}"),
    }
}

fn column(x: &mut [f64]) -> MatMut<'_, f64> {
    let n = x.len();
    MatMut::from_column_major_slice_mut(x, n, 1)
}

/// Sparse LU with row interchanges (faer), for matrices of any kind.
#[derive(Default)]
pub struct FaerLu {
    ready: Option<Ready<SymbolicLu<usize>>>,
    numeric: NumericLu<usize, f64>,
}

impl FaerLu {
    /// A solver without a pattern.
    pub fn new() -> Self {
        Self::default()
    }

    /// Size of one component of the mechanism that the last, failed factorisation found, relative
    /// to the largest.
    pub(super) fn mobility(&self, unknown: usize) -> f64 {
        self.ready.as_ref().map_or(0.0, |ready| {
            ready.columns.x[unknown].abs() / max_abs(&ready.columns.x)
        })
    }

    /// Factorises `A` with a small shift of the scaled diagonal, without any check.
    pub(super) fn factorise_shifted(&mut self, values: &[f64]) -> Result<(), LinearError> {
        let Some(Ready {
            columns,
            symbolic,
            memory,
        }) = &mut self.ready
        else {
            return Err(LinearError::NotReady { call: "factorise" });
        };
        columns.load(values)?;
        columns.shift_diagonal();
        columns.finished = lu(columns, memory, symbolic, &mut self.numeric)?;
        Ok(())
    }

    /// Solution without a residual check, for inverse iteration.
    pub(super) fn solve_unchecked(&mut self, b: &mut [f64]) -> Result<(), LinearError> {
        match &mut self.ready {
            Some(Ready {
                columns,
                symbolic,
                memory,
            }) if columns.finished => {
                for (b, s) in b.iter_mut().zip(&columns.scales) {
                    *b *= s;
                }
                let stack = MemStack::new(memory);
                lu_solve(symbolic, &self.numeric, b, stack);
                for (b, s) in b.iter_mut().zip(&columns.scales) {
                    *b *= s;
                }
                Ok(())
            }
            _ => Err(LinearError::NotReady { call: "solve" }),
        }
    }
}

/// One numeric LU; false if it found a structurally zero pivot.
fn lu(
    columns: &Columns,
    memory: &mut MemBuffer,
    symbolic: &SymbolicLu<usize>,
    numeric: &mut NumericLu<usize, f64>,
) -> Result<bool, LinearError> {
    use faer::sparse::linalg::LuError;
    let a = SparseColMatRef::new(structure(columns), &columns.values);
    let stack = MemStack::new(memory);
    match symbolic.factorize_numeric_lu(numeric, a, Par::Seq, stack, Default::default()) {
        Ok(_) => Ok(true),
        Err(LuError::SymbolicSingular { .. }) => Ok(false),
        Err(LuError::Generic(error)) => Err(library(error)),
    }
}

fn lu_solve(
    symbolic: &SymbolicLu<usize>,
    numeric: &NumericLu<usize, f64>,
    x: &mut [f64],
    stack: &mut MemStack,
) {
    LuRef::new_unchecked(symbolic, numeric).solve_in_place_with_conj(
        Conj::No,
        column(x),
        Par::Seq,
        stack,
    );
}

impl LinearSolver for FaerLu {
    fn analyse(&mut self, pattern: &BlockPattern, _: Symmetry) -> Result<(), LinearError> {
        self.ready = None;
        let columns = Columns::new(pattern);
        let symbolic = factorize_symbolic_lu(structure(&columns), LuSymbolicParams::default())
            .map_err(library)?;
        let scratch = symbolic
            .factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        let memory = MemBuffer::try_new(scratch).map_err(library)?;
        self.ready = Some(Ready {
            columns,
            symbolic,
            memory,
        });
        Ok(())
    }

    fn factorise(&mut self, values: &[f64]) -> Result<(), LinearError> {
        let Some(Ready {
            columns,
            symbolic,
            memory,
        }) = &mut self.ready
        else {
            return Err(LinearError::NotReady { call: "factorise" });
        };
        columns.load(values)?;
        let mut condition = f64::INFINITY;
        if lu(columns, memory, symbolic, &mut self.numeric)? {
            columns.probe();
            let stack = MemStack::new(memory);
            lu_solve(symbolic, &self.numeric, &mut columns.x, stack);
            condition = columns.witnessed_condition();
            if condition <= columns.condition_limit() {
                columns.finished = true;
                return Ok(());
            }
        }
        if !condition.is_finite() {
            condition = f64::INFINITY;
            columns.shift_diagonal();
            if lu(columns, memory, symbolic, &mut self.numeric)? {
                columns.probe();
                let stack = MemStack::new(memory);
                lu_solve(symbolic, &self.numeric, &mut columns.x, stack);
            }
        }
        Err(columns.singular(condition))
    }

    fn solve(&mut self, _: Option<&[f64]>, b: &mut [f64]) -> Result<(), LinearError> {
        let Some(Ready {
            columns,
            symbolic,
            memory,
        }) = &mut self.ready
        else {
            return Err(LinearError::NotReady { call: "solve" });
        };
        let numeric = &self.numeric;
        columns.solve(b, |x| lu_solve(symbolic, numeric, x, MemStack::new(memory)))
    }
}

/// Sparse Cholesky (faer) for symmetric matrices; indefinite ones go to [`FaerLu`].
#[derive(Default)]
pub struct FaerCholesky {
    ready: Option<Ready<SymbolicCholesky<usize>>>,
    factor: Vec<f64>,
    lu: FaerLu,
    /// Number of factorisations in a row that were not positive definite.
    misses: usize,
}

/// Number of indefinite factorisations in a row after which Cholesky is not tried any more.
const MISSES: usize = 3;

impl FaerCholesky {
    /// A solver without a pattern.
    pub fn new() -> Self {
        Self::default()
    }

    /// Whether the last matrix was positive definite.
    pub fn is_positive_definite(&self) -> bool {
        self.misses == 0
    }
}

fn cholesky_solve(
    symbolic: &SymbolicCholesky<usize>,
    factor: &[f64],
    x: &mut [f64],
    stack: &mut MemStack,
) {
    LltRef::new(symbolic, factor).solve_in_place_with_conj(Conj::No, column(x), Par::Seq, stack);
}

impl LinearSolver for FaerCholesky {
    fn analyse(&mut self, pattern: &BlockPattern, _: Symmetry) -> Result<(), LinearError> {
        self.ready = None;
        self.misses = 0;
        self.lu = FaerLu::new();
        let columns = Columns::new(pattern);
        let symbolic = factorize_symbolic_cholesky(
            structure(&columns),
            Side::Lower,
            SymmetricOrdering::Amd,
            CholeskySymbolicParams::default(),
        )
        .map_err(library)?;
        let scratch = symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        let memory = MemBuffer::try_new(scratch).map_err(library)?;
        self.factor = vec![0.0; symbolic.len_val()];
        self.ready = Some(Ready {
            columns,
            symbolic,
            memory,
        });
        Ok(())
    }

    fn factorise(&mut self, values: &[f64]) -> Result<(), LinearError> {
        let Some(Ready {
            columns,
            symbolic,
            memory,
        }) = &mut self.ready
        else {
            return Err(LinearError::NotReady { call: "factorise" });
        };
        if self.misses < MISSES {
            columns.load(values)?;
            let a = SparseColMatRef::new(structure(columns), &columns.values);
            let stack = MemStack::new(memory);
            let result = symbolic.factorize_numeric_llt(
                &mut self.factor,
                a,
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                stack,
                Default::default(),
            );
            if result.is_ok() {
                self.misses = 0;
                columns.probe();
                let stack = MemStack::new(memory);
                cholesky_solve(symbolic, &self.factor, &mut columns.x, stack);
                let condition = columns.witnessed_condition();
                if condition <= columns.condition_limit() {
                    columns.finished = true;
                    return Ok(());
                }
                if condition.is_finite() {
                    return Err(columns.singular(condition));
                }
            }
            self.misses += 1;
        }
        if self.lu.ready.is_none() {
            self.lu.analyse(&columns.pattern, Symmetry::Symmetric)?;
        }
        self.lu.factorise(values)
    }

    fn solve(&mut self, values: Option<&[f64]>, b: &mut [f64]) -> Result<(), LinearError> {
        match &mut self.ready {
            None => Err(LinearError::NotReady { call: "solve" }),
            Some(_) if self.misses > 0 => self.lu.solve(values, b),
            Some(Ready {
                columns,
                symbolic,
                memory,
            }) => {
                let factor = &self.factor;
                columns.solve(b, |x| {
                    cholesky_solve(symbolic, factor, x, MemStack::new(memory))
                })
            }
        }
    }

    /// Zero if the last matrix was positive definite; else from the signs of an LDLᵀ factorisation,
    /// unless a pivot is too small to have a sign.
    fn negative_pivots(&mut self, values: &[f64]) -> Option<usize> {
        let ready = self.ready.as_mut()?;
        if self.misses == 0 {
            return ready.columns.finished.then_some(0);
        }
        self.signs(values)
    }
}

impl FaerCholesky {
    /// Negative pivots of an LDLᵀ factorisation, unless one is too small to have a sign; replaces
    /// the present factors.
    ///
    /// Unknowns without a diagonal, Lagrange multipliers, get a small negative one: their equations
    /// become stiff springs, which does not change the signs.
    pub(super) fn signs(&mut self, values: &[f64]) -> Option<usize> {
        let Ready {
            columns, symbolic, ..
        } = self.ready.as_mut()?;
        columns.load(values).ok()?;
        columns.soften();
        let scratch = symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = MemBuffer::try_new(scratch).ok()?;
        symbolic
            .factorize_numeric_ldlt(
                &mut self.factor,
                SparseColMatRef::new(structure(columns), &columns.values),
                Side::Lower,
                LdltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                Default::default(),
            )
            .ok()?;
        let mut count = 0;
        let mut regular = true;
        let mut see = |pivot: f64| {
            count += usize::from(pivot < 0.0);
            regular &= pivot.abs() > rounding_level(columns.pattern.blocks());
        };
        match symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(l) => {
                let starts = &l.col_ptr()[..l.nrows()];
                starts.iter().for_each(|&start| see(self.factor[start]));
            }
            SymbolicCholeskyRaw::Supernodal(l) => {
                let spans = l.supernode_begin().iter().zip(l.supernode_end());
                for ((&begin, &end), bounds) in spans.zip(l.col_ptr_for_val().windows(2)) {
                    // A dense trapezium, column by column.
                    let rows = (bounds[1] - bounds[0]) / (end - begin);
                    (0..end - begin).for_each(|k| see(self.factor[bounds[0] + k * (rows + 1)]));
                }
            }
        }
        regular.then_some(count)
    }
}
