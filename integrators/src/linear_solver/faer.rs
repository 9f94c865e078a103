//! The general sparse solvers of faer. Apart from them only the search for modes uses faer.
//!
//! faer's LU reports success on singular matrices and returns NaN or meaningless numbers. So every
//! factorisation is probed with one right-hand side of ±1-like entries: the largest component of
//! the solution bounds the condition number from below. If it is beyond working precision, the
//! solution is a mechanism, whose largest component is named.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::mat::MatMut;
use faer::perm::PermRef;
use faer::sparse::linalg::LuError;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::linalg::lu::{
    LuRef, LuSymbolicParams, NumericLu, SymbolicLu, factorize_symbolic_lu,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Par, Side};
use pullback_manifold::sparse::BlockPattern;

use super::columns::Columns;
use super::{LinearError, LinearSolver, rounding_level};
use crate::registers::clear_upper_halves;

fn structure(columns: &Columns) -> SymbolicSparseColMatRef<'_, usize> {
    let n = columns.scales.len();
    SymbolicSparseColMatRef::new_checked(n, n, &columns.starts, None, &columns.rows)
}

fn matrix(columns: &Columns) -> SparseColMatRef<'_, usize, f64> {
    SparseColMatRef::new(structure(columns), &columns.values)
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

/// A kind of factorisation, with its storage.
pub trait Factors: Sized + Send {
    /// The structure of the factors.
    fn new(columns: &Columns) -> Result<Self, LinearError>;

    /// Factorises; false if a pivot is zero.
    fn factorise(&mut self, columns: &Columns) -> Result<bool, LinearError>;

    /// Replaces the right-hand side by the solution.
    fn solve(&mut self, x: &mut [f64]);

    /// The pivots, if their signs are those of the eigenvalues.
    fn pivots(&self) -> Option<Vec<f64>> {
        None
    }
}

/// See [`FaerLu`].
pub struct Lu {
    symbolic: SymbolicLu<usize>,
    numeric: NumericLu<usize, f64>,
    memory: MemBuffer,
}

impl Factors for Lu {
    fn new(columns: &Columns) -> Result<Self, LinearError> {
        let symbolic = factorize_symbolic_lu(structure(columns), LuSymbolicParams::default())
            .map_err(library)?;
        let scratch = symbolic
            .factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        Ok(Self {
            symbolic,
            numeric: NumericLu::default(),
            memory: MemBuffer::try_new(scratch).map_err(library)?,
        })
    }

    fn factorise(&mut self, columns: &Columns) -> Result<bool, LinearError> {
        let (a, stack) = (matrix(columns), MemStack::new(&mut self.memory));
        let numeric = &mut self.numeric;
        let result =
            (self.symbolic).factorize_numeric_lu(numeric, a, Par::Seq, stack, Default::default());
        clear_upper_halves();
        match result {
            Ok(_) => Ok(true),
            Err(LuError::SymbolicSingular { .. }) => Ok(false),
            Err(LuError::Generic(error)) => Err(library(error)),
        }
    }

    fn solve(&mut self, x: &mut [f64]) {
        let stack = MemStack::new(&mut self.memory);
        LuRef::new_unchecked(&self.symbolic, &self.numeric).solve_in_place_with_conj(
            Conj::No,
            column(x),
            Par::Seq,
            stack,
        );
        clear_upper_halves();
    }
}

/// See [`FaerLdlt`].
pub struct Ldlt {
    symbolic: SymbolicCholesky<usize>,
    factor: Vec<f64>,
    memory: MemBuffer,
}

impl Ldlt {
    fn ordered(
        columns: &Columns,
        order: SymmetricOrdering<'_, usize>,
    ) -> Result<Self, LinearError> {
        let symbolic = factorize_symbolic_cholesky(
            structure(columns),
            Side::Lower,
            order,
            CholeskySymbolicParams::default(),
        )
        .map_err(library)?;
        let scratch = symbolic
            .factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        Ok(Self {
            factor: vec![0.0; symbolic.len_val()],
            symbolic,
            memory: MemBuffer::try_new(scratch).map_err(library)?,
        })
    }

    /// Multipliers are eliminated before all others, which leaves K + HᵀH/ε: what they hold alone is not singular.
    fn after_multipliers(columns: &Columns) -> Result<Self, LinearError> {
        let usual = Self::new(columns)?;
        let Some(order) = usual.symbolic.perm() else {
            return Ok(usual);
        };
        let mut order = order.arrays().0.to_vec();
        order.sort_by_key(|&i| !columns.pattern.coordinates()[i].is_multiplier);
        let mut position = vec![0; order.len()];
        (order.iter().enumerate()).for_each(|(k, &i)| position[i] = k);
        let order = PermRef::new_checked(&order, &position, order.len());
        Self::ordered(columns, SymmetricOrdering::Custom(order))
    }
}

impl Factors for Ldlt {
    fn new(columns: &Columns) -> Result<Self, LinearError> {
        Self::ordered(columns, SymmetricOrdering::Amd)
    }

    fn factorise(&mut self, columns: &Columns) -> Result<bool, LinearError> {
        let result = self.symbolic.factorize_numeric_ldlt(
            &mut self.factor,
            matrix(columns),
            Side::Lower,
            LdltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut self.memory),
            Default::default(),
        );
        clear_upper_halves();
        Ok(result.is_ok())
    }

    fn solve(&mut self, x: &mut [f64]) {
        let stack = MemStack::new(&mut self.memory);
        LdltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            column(x),
            Par::Seq,
            stack,
        );
        clear_upper_halves();
    }

    fn pivots(&self) -> Option<Vec<f64>> {
        Some(match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(l) => {
                let starts = &l.col_ptr()[..l.nrows()];
                starts.iter().map(|&start| self.factor[start]).collect()
            }
            SymbolicCholeskyRaw::Supernodal(l) => {
                let spans = l.supernode_begin().iter().zip(l.supernode_end());
                let pivots = spans.zip(l.col_ptr_for_val().windows(2));
                let pivots = pivots.flat_map(|((&begin, &end), bounds)| {
                    // A dense trapezium, column by column.
                    let (first, rows) = (bounds[0], (bounds[1] - bounds[0]) / (end - begin));
                    (0..end - begin).map(move |k| self.factor[first + k * (rows + 1)])
                });
                pivots.collect()
            }
        })
    }
}

/// A solver of faer.
pub struct Faer<F> {
    columns: Columns,
    factors: F,
}

/// Sparse LU with row interchanges (faer), for matrices of any kind.
pub type FaerLu = Faer<Lu>;

/// Sparse LDLᵀ without interchanges (faer), for symmetric matrices that need none.
pub type FaerLdlt = Faer<Ldlt>;

impl<F: Factors> Faer<F> {
    /// Finds the structure of the factors.
    ///
    /// # Errors
    /// [`LinearError::Library`].
    pub fn new(pattern: &BlockPattern) -> Result<Self, LinearError> {
        let columns = Columns::new(pattern);
        let factors = F::new(&columns)?;
        Ok(Self { columns, factors })
    }

    /// Factorises `A` with a small shift of the scaled diagonal, without any check; the scaled matrix, and its factors.
    pub(super) fn shifted(&mut self, values: &[f64]) -> Result<(&Columns, &mut F), LinearError> {
        let Self { columns, factors } = self;
        columns.load(values)?;
        columns.shift_diagonal();
        match factors.factorise(columns)? {
            true => Ok((columns, factors)),
            false => Err(LinearError::NotReady),
        }
    }
}

/// Compliances of the equation of a multiplier in the scaled matrix when only signs are needed: small beside that of one
/// element, and large beside rounding errors.
const SOFTNESS: [f64; 2] = [1e-4, 1e-7];

impl FaerLdlt {
    /// A solver for [`signs`](Self::signs).
    pub(super) fn for_signs(pattern: &BlockPattern) -> Result<Self, LinearError> {
        let columns = Columns::new(pattern);
        let factors = Ldlt::after_multipliers(&columns)?;
        Ok(Self { columns, factors })
    }

    /// Negative pivots of a factorisation for their signs alone. Multipliers get a small diagonal, with which their equations
    /// become stiff springs, of negative stiffness if it is positive. The number falls with that diagonal, so that it is the
    /// one without where it is the same for both signs.
    pub(super) fn signs(&mut self, values: &[f64]) -> Option<usize> {
        let Self { columns, factors } = self;
        let mut count = |compliance: f64| {
            columns.load(values).ok()?;
            columns.soften(compliance);
            factors.factorise(columns).ok().filter(|regular| *regular)?;
            negative(columns, factors)
        };
        let mut both = SOFTNESS.iter().map(|s| [*s, -s].map(&mut count));
        both.find_map(|[above, below]| above.filter(|_| above == below))
    }
}

/// Number of negative pivots, unless one is too small to have a sign.
fn negative(columns: &Columns, factors: &impl Factors) -> Option<usize> {
    let (pivots, limit) = (factors.pivots()?, rounding_level(columns.pattern.blocks()));
    let regular = pivots.iter().all(|pivot| pivot.abs() > limit);
    regular.then(|| pivots.iter().filter(|pivot| **pivot < 0.0).count())
}

impl<F: Factors> LinearSolver for Faer<F> {
    fn factorise(&mut self, values: &[f64]) -> Result<(), LinearError> {
        let Self { columns, factors } = self;
        columns.load(values)?;
        let mut condition = f64::INFINITY;
        if factors.factorise(columns)? {
            condition = columns.probe(|x| factors.solve(x));
            if condition <= columns.condition_limit() {
                columns.finished = true;
                return Ok(());
            }
        }
        if !condition.is_finite() {
            condition = f64::INFINITY;
            columns.shift_diagonal();
            if factors.factorise(columns)? {
                columns.probe(|x| factors.solve(x));
            }
        }
        Err(columns.singular(condition))
    }

    fn solve(&mut self, _: Option<&[f64]>, b: &mut [f64]) -> Result<(), LinearError> {
        let Self { columns, factors } = self;
        columns.solve(b, |x| factors.solve(x))
    }

    /// From the signs of the pivots of an LDLᵀ factorisation.
    fn negative_pivots(&mut self, _: &[f64]) -> Option<usize> {
        (self.columns.finished).then(|| negative(&self.columns, &self.factors))?
    }
}
