//! The general sparse solvers of faer. No other file knows about faer.
//!
//! faer's LU reports success on singular matrices and answers with NaN or with nonsense, so that
//! every factorisation is probed with one right-hand side of ±1-like entries: the largest
//! component of the answer bounds the condition number from below, and where it is beyond working
//! precision the answer is a mechanism, whose largest component is named.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::mat::MatMut;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::linalg::lu::{
    LuRef, LuSymbolicParams, NumericLu, SymbolicLu, factorize_symbolic_lu,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, Par, Side};
use pullback_manifold::sparse::BlockPattern;

use super::{
    LinearError, LinearSolver, REFINEMENTS, RESIDUAL_GOAL, RESIDUAL_LIMIT, Symmetry, check_length,
    first_non_finite, max_abs, rounding_level, scaling,
};

/// What is added to the diagonal of a scaled matrix whose factors are not finite, only to learn
/// the direction of its mechanism.
const SHIFT: f64 = 1e-9;

/// The scaled matrix column by column, and the work vectors of the checks.
struct Columns {
    pattern: BlockPattern,
    structure: SymbolicSparseColMat<usize>,
    values: Vec<f64>,
    scales: Vec<f64>,
    norm: f64,
    rhs: Vec<f64>,
    x: Vec<f64>,
    residual: Vec<f64>,
    memory: MemBuffer,
    finished: bool,
}

fn library(reason: impl std::fmt::Debug) -> LinearError {
    LinearError::Library {
        reason: format!("{reason:?}"),
    }
}

impl Columns {
    fn new(pattern: &BlockPattern) -> Result<Self, LinearError> {
        let n = pattern.dim();
        let mut starts = Vec::with_capacity(n + 1);
        let mut rows = Vec::with_capacity(pattern.len());
        starts.push(0);
        for j in 0..pattern.blocks() {
            for _ in pattern.unknowns(j) {
                rows.extend(pattern.column(j).flat_map(|(i, _)| pattern.unknowns(i)));
                starts.push(rows.len());
            }
        }
        Ok(Self {
            pattern: pattern.clone(),
            structure: SymbolicSparseColMat::new_checked(n, n, starts, None, rows),
            values: vec![0.0; pattern.len()],
            scales: vec![1.0; n],
            norm: 0.0,
            rhs: vec![0.0; n],
            x: vec![0.0; n],
            residual: vec![0.0; n],
            memory: MemBuffer::try_new(StackReq::EMPTY).map_err(library)?,
            finished: false,
        })
    }

    fn load(&mut self, values: &[f64]) -> Result<(), LinearError> {
        check_length("matrix", self.pattern.len(), values.len())?;
        self.finished = false;
        let pattern = &self.pattern;
        scaling::scales(pattern, values, &mut self.scales, &mut self.x)?;
        self.norm = scaling::norm(pattern, values, &self.scales);
        let mut place = 0;
        for j in 0..pattern.blocks() {
            for (c, unknown) in pattern.unknowns(j).enumerate() {
                for (i, range) in pattern.column(j) {
                    let height = pattern.size(i);
                    let column = &values[range][c * height..(c + 1) * height];
                    for (value, r) in column.iter().zip(pattern.unknowns(i)) {
                        self.values[place] = value * self.scales[r] * self.scales[unknown];
                        place += 1;
                    }
                }
            }
        }
        Ok(())
    }

    fn shift_diagonal(&mut self) {
        let (starts, rows) = (self.structure.col_ptr(), self.structure.row_idx());
        for c in 0..self.scales.len() {
            for k in starts[c]..starts[c + 1] {
                if rows[k] == c {
                    self.values[k] += SHIFT;
                }
            }
        }
    }

    /// A fixed right-hand side without structure: magnitudes between 1/2 and 1, mixed signs.
    fn probe(&mut self) {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        for x in &mut self.x {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            let magnitude = 0.5 + (state >> 12) as f64 / (1u64 << 53) as f64;
            *x = if state & 1 == 0 {
                magnitude
            } else {
                -magnitude
            };
        }
    }

    /// Condition number that the answer to the probe, now in `x`, witnesses.
    fn witnessed_condition(&self) -> f64 {
        self.norm * max_abs(&self.x)
    }

    fn condition_limit(&self) -> f64 {
        1.0 / rounding_level(self.pattern.blocks())
    }

    fn singular(&self, condition: f64) -> LinearError {
        let mut unknown = 0;
        for (i, x) in self.x.iter().enumerate() {
            // Written so that NaN counts as largest.
            if !(x.abs() <= self.x[unknown].abs()) {
                unknown = i;
                if x.is_nan() {
                    break;
                }
            }
        }
        LinearError::Singular {
            unknown,
            condition,
            limit: self.condition_limit(),
        }
    }

    /// Solves with `inverse` and checks; `inverse` works on the scaled system.
    fn solve(
        &mut self,
        b: &mut [f64],
        mut inverse: impl FnMut(&mut [f64], &mut MemStack),
    ) -> Result<(), LinearError> {
        check_length("right-hand side", self.scales.len(), b.len())?;
        if !self.finished {
            return Err(LinearError::NotReady { asked: "solve" });
        }
        if let Some(unknown) = first_non_finite(b) {
            return Err(LinearError::NonFinite {
                what: "right-hand side",
                unknown,
            });
        }
        for ((y, b), s) in self.rhs.iter_mut().zip(&*b).zip(&self.scales) {
            *y = b * s;
        }
        self.x.copy_from_slice(&self.rhs);
        inverse(&mut self.x, MemStack::new(&mut self.memory));
        let mut best = f64::INFINITY;
        for refinement in 0..=REFINEMENTS {
            let relative = self.relative_residual()?;
            if relative <= RESIDUAL_GOAL || refinement == REFINEMENTS || relative > 0.5 * best {
                if !(relative <= RESIDUAL_LIMIT) {
                    return Err(LinearError::Residual {
                        residual: relative,
                        limit: RESIDUAL_LIMIT,
                    });
                }
                break;
            }
            best = relative;
            inverse(&mut self.residual, MemStack::new(&mut self.memory));
            for (x, r) in self.x.iter_mut().zip(&self.residual) {
                *x += r;
            }
        }
        for ((b, x), s) in b.iter_mut().zip(&self.x).zip(&self.scales) {
            *b = x * s;
        }
        Ok(())
    }

    fn relative_residual(&mut self) -> Result<f64, LinearError> {
        let (starts, rows) = (self.structure.col_ptr(), self.structure.row_idx());
        self.residual.copy_from_slice(&self.rhs);
        for (c, x) in self.x.iter().enumerate() {
            let range = starts[c]..starts[c + 1];
            for (&r, a) in rows[range.clone()].iter().zip(&self.values[range]) {
                self.residual[r] -= a * x;
            }
        }
        let r = max_abs(&self.residual);
        let size = self.norm * max_abs(&self.x) + max_abs(&self.rhs);
        if r <= f64::MAX && size <= f64::MAX {
            return Ok(if r == 0.0 { 0.0 } else { r / size });
        }
        Err(LinearError::NonFinite {
            what: "solution",
            unknown: first_non_finite(&self.x).unwrap_or(0),
        })
    }
}

fn column(x: &mut [f64]) -> MatMut<'_, f64> {
    let n = x.len();
    MatMut::from_column_major_slice_mut(x, n, 1)
}

/// Sparse LU with row interchanges (faer), for matrices of any kind.
#[derive(Default)]
pub struct FaerLu {
    ready: Option<(Columns, SymbolicLu<usize>)>,
    numeric: NumericLu<usize, f64>,
}

impl FaerLu {
    /// A solver that knows no pattern yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Size of one component of the mechanism that the last, failed factorisation found, relative
    /// to the largest.
    pub(super) fn mobility(&self, unknown: usize) -> f64 {
        self.ready.as_ref().map_or(0.0, |(columns, _)| {
            columns.x[unknown].abs() / max_abs(&columns.x)
        })
    }

    /// Factorises `A` plus a shift of [`SHIFT`] of the scaled matrix, without any check.
    pub(super) fn factorise_shifted(&mut self, values: &[f64]) -> Result<(), LinearError> {
        let Some((columns, symbolic)) = &mut self.ready else {
            return Err(LinearError::NotReady { asked: "factorise" });
        };
        columns.load(values)?;
        columns.shift_diagonal();
        columns.finished = lu(columns, symbolic, &mut self.numeric)?;
        Ok(())
    }

    /// Solution without residual check: what an inverse iteration wants.
    pub(super) fn solve_unchecked(&mut self, b: &mut [f64]) -> Result<(), LinearError> {
        match &mut self.ready {
            Some((columns, symbolic)) if columns.finished => {
                for (b, s) in b.iter_mut().zip(&columns.scales) {
                    *b *= s;
                }
                let stack = MemStack::new(&mut columns.memory);
                lu_solve(symbolic, &self.numeric, b, stack);
                for (b, s) in b.iter_mut().zip(&columns.scales) {
                    *b *= s;
                }
                Ok(())
            }
            _ => Err(LinearError::NotReady { asked: "solve" }),
        }
    }
}

/// One numeric LU; false if it found a structurally zero pivot.
fn lu(
    columns: &mut Columns,
    symbolic: &SymbolicLu<usize>,
    numeric: &mut NumericLu<usize, f64>,
) -> Result<bool, LinearError> {
    use faer::sparse::linalg::LuError;
    let a = SparseColMatRef::new(columns.structure.as_ref(), &columns.values);
    let stack = MemStack::new(&mut columns.memory);
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
        let mut columns = Columns::new(pattern)?;
        let symbolic =
            factorize_symbolic_lu(columns.structure.as_ref(), LuSymbolicParams::default())
                .map_err(library)?;
        let scratch = symbolic
            .factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        columns.memory = MemBuffer::try_new(scratch).map_err(library)?;
        self.ready = Some((columns, symbolic));
        Ok(())
    }

    fn factorise(&mut self, values: &[f64]) -> Result<(), LinearError> {
        let Some((columns, symbolic)) = &mut self.ready else {
            return Err(LinearError::NotReady { asked: "factorise" });
        };
        columns.load(values)?;
        let mut condition = f64::INFINITY;
        if lu(columns, symbolic, &mut self.numeric)? {
            columns.probe();
            let stack = MemStack::new(&mut columns.memory);
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
            if lu(columns, symbolic, &mut self.numeric)? {
                columns.probe();
                let stack = MemStack::new(&mut columns.memory);
                lu_solve(symbolic, &self.numeric, &mut columns.x, stack);
            }
        }
        Err(columns.singular(condition))
    }

    fn solve(&mut self, b: &mut [f64]) -> Result<(), LinearError> {
        let Some((columns, symbolic)) = &mut self.ready else {
            return Err(LinearError::NotReady { asked: "solve" });
        };
        let numeric = &self.numeric;
        columns.solve(b, |x, stack| lu_solve(symbolic, numeric, x, stack))
    }
}

/// Sparse Cholesky (faer) for symmetric matrices; those that turn out not to be positive definite
/// go to [`FaerLu`].
#[derive(Default)]
pub struct FaerCholesky {
    ready: Option<(Columns, SymbolicCholesky<usize>)>,
    factor: Vec<f64>,
    lu: FaerLu,
    /// Factorisations in a row that were not positive definite.
    misses: usize,
}

/// Indefinite factorisations in a row after which Cholesky is not tried any more.
const MISSES: usize = 3;

impl FaerCholesky {
    /// A solver that knows no pattern yet.
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
        let mut columns = Columns::new(pattern)?;
        let symbolic = factorize_symbolic_cholesky(
            columns.structure.as_ref(),
            Side::Lower,
            SymmetricOrdering::Amd,
            CholeskySymbolicParams::default(),
        )
        .map_err(library)?;
        let scratch = symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        columns.memory = MemBuffer::try_new(scratch).map_err(library)?;
        self.factor = vec![0.0; symbolic.len_val()];
        self.ready = Some((columns, symbolic));
        Ok(())
    }

    fn factorise(&mut self, values: &[f64]) -> Result<(), LinearError> {
        let Some((columns, symbolic)) = &mut self.ready else {
            return Err(LinearError::NotReady { asked: "factorise" });
        };
        if self.misses < MISSES {
            columns.load(values)?;
            let a = SparseColMatRef::new(columns.structure.as_ref(), &columns.values);
            let stack = MemStack::new(&mut columns.memory);
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
                let stack = MemStack::new(&mut columns.memory);
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

    fn solve(&mut self, b: &mut [f64]) -> Result<(), LinearError> {
        match &mut self.ready {
            None => Err(LinearError::NotReady { asked: "solve" }),
            Some(_) if self.misses > 0 => self.lu.solve(b),
            Some((columns, symbolic)) => {
                let factor = &self.factor;
                columns.solve(b, |x, stack| cholesky_solve(symbolic, factor, x, stack))
            }
        }
    }
}
