//! Sparse LU of dense blocks.
//!
//! Panels are eliminated in minimum degree order ([`super::ordering`]); rows are interchanged only
//! inside a diagonal block. That is stable for the matrices it is meant for (positive definite
//! ones, and effective tangents dominated by them), and everything else is noticed: pivots against
//! the rounding level of the scaled matrix, growth of the pivots, residual of every solution.
//!
//! # When is a pivot zero?
//! The matrix is scaled so that original diagonals are of order one. A pivot below
//! [`rounding_level`](super::rounding_level), about 16 + 4√nodes machine epsilons, has lost every
//! digit to cancellation and is reported as [`LinearError::VanishingPivot`]. An ill-conditioned
//! but supported structure stays clear of that in the order used: eliminated from its free end, a
//! cantilever of any length has pivots of the order of single elements, although its condition
//! number grows with the fourth power of their number. Eliminated from its support, the last
//! pivot falls like 3/N³ relative to an element's and stays above the level up to N of about 10⁴;
//! there the condition number reaches 1/ε and no algorithm can tell the two apart from the values.

use pullback_manifold::sparse::BlockPattern;

use super::symbolic::{Load, Symbolic};
use super::{
    LinearError, LinearSolver, REFINEMENTS, RESIDUAL_GOAL, RESIDUAL_LIMIT, Symmetry, check_length,
    first_non_finite, kernels, max_abs, rounding_level, scaling,
};

/// Pivots this much larger than the entries of the scaled matrix are called growth.
const GROWTH_LIMIT: f64 = 1e8;

/// Block updates beyond which [`BlockLu`] refuses to analyse: half a minute of dense 6 × 6 ones.
const MAX_UPDATES: usize = 50_000_000;

/// Sparse LU of dense blocks; see the module's source for method and criteria.
#[derive(Default)]
pub struct BlockLu {
    ready: Option<Ready>,
    factorised: bool,
    /// Replace vanishing pivots by this instead of failing; 0 for an honest factorisation.
    floor: f64,
}

/// What `analyse` allocates.
struct Ready {
    pattern: BlockPattern,
    symbolic: Symbolic,
    factors: Vec<f64>,
    /// The scaled matrix in the order in which its blocks are loaded, for residuals.
    matrix: Vec<f64>,
    /// Interchanges inside the diagonal blocks, in elimination order.
    swaps: Vec<u32>,
    swapped: Vec<bool>,
    /// Scales in elimination order.
    scales: Vec<f64>,
    /// Sum of squares of each block row and column.
    squares: Vec<f64>,
    norm: f64,
    smallest: f64,
    rhs: Vec<f64>,
    x: Vec<f64>,
    residual: Vec<f64>,
}

enum Failure {
    /// The diagonal is no measure of the entries.
    Scale,
    Error(LinearError),
}

impl BlockLu {
    /// A solver that knows no pattern yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// A solver that replaces vanishing pivots by `floor` (of the scaled matrix).
    pub(super) fn perturbed(floor: f64) -> Self {
        Self {
            floor,
            ..Self::default()
        }
    }

    /// Floating point operations of one factorisation, once analysed.
    pub fn flops(&self) -> f64 {
        self.ready.as_ref().map_or(0.0, |r| r.symbolic.flops)
    }

    /// Number of values in the factors, once analysed.
    pub fn factor_len(&self) -> usize {
        self.ready.as_ref().map_or(0, |r| r.symbolic.len)
    }

    /// Whether this solver is likely faster than a general sparse LU on the analysed pattern.
    ///
    /// Estimates in nanoseconds, measured on chains and grids: small blocks cost 50 per panel and
    /// 15 per block update, and run at two operations per nanosecond; supernodal LU costs 30 per
    /// entry of the matrix for its bookkeeping and runs at ten.
    pub fn suits(&self) -> bool {
        let Some(ready) = &self.ready else {
            return false;
        };
        let symbolic = &ready.symbolic;
        let here = 50.0 * symbolic.panels.len() as f64
            + 15.0 * symbolic.targets.len() as f64
            + symbolic.flops / 2.0;
        let there = 30.0 * ready.pattern.len() as f64 + symbolic.flops / 10.0;
        here < there
    }

    /// Smallest pivot of the last factorisation relative to its original diagonal scale.
    pub fn smallest_pivot(&self) -> f64 {
        self.ready.as_ref().map_or(f64::NAN, |r| r.smallest)
    }

    /// The values of the last factorisation, exactly (of a symmetric matrix: both halves).
    pub(super) fn values(&self, values: &mut Vec<f64>) {
        values.clear();
        if let Some(ready) = &self.ready {
            values.resize(ready.pattern.len(), 0.0);
            ready.original(values);
        }
    }

    /// Solution without residual check: what an inverse iteration wants.
    pub(super) fn solve_unchecked(&mut self, b: &mut [f64]) -> Result<(), LinearError> {
        let Some(ready) = self.ready.as_mut().filter(|_| self.factorised) else {
            return Err(LinearError::NotReady { asked: "solve" });
        };
        ready.gather(b);
        ready.substitute(false);
        ready.scatter(b);
        Ok(())
    }
}

impl LinearSolver for BlockLu {
    fn analyse(&mut self, pattern: &BlockPattern, symmetry: Symmetry) -> Result<(), LinearError> {
        self.ready = None;
        self.factorised = false;
        let symbolic = Symbolic::new(pattern, symmetry, MAX_UPDATES)?;
        let n = pattern.dim();
        let panels = symbolic.panels.len();
        self.ready = Some(Ready {
            pattern: pattern.clone(),
            factors: vec![0.0; symbolic.len],
            matrix: vec![0.0; symbolic.read],
            swaps: vec![0; n],
            swapped: vec![false; panels],
            scales: vec![1.0; n],
            squares: vec![0.0; panels],
            norm: 0.0,
            smallest: 0.0,
            rhs: vec![0.0; n],
            x: vec![0.0; n],
            residual: vec![0.0; n],
            symbolic,
        });
        Ok(())
    }

    fn factorise(&mut self, values: &[f64]) -> Result<(), LinearError> {
        self.factorised = false;
        let Some(ready) = &mut self.ready else {
            return Err(LinearError::NotReady { asked: "factorise" });
        };
        check_length("matrix", ready.pattern.len(), values.len())?;
        let result = match ready.factorise(values, self.floor, false) {
            Err(Failure::Scale) => {
                ready.equilibrate(values)?;
                ready.factorise(values, self.floor, true)
            }
            result => result,
        };
        match result {
            Ok(()) => {
                self.factorised = true;
                Ok(())
            }
            Err(Failure::Error(error)) => Err(error),
            // After equilibration no entry exceeds one by much, so a second refusal is overflow.
            Err(Failure::Scale) => Err(LinearError::NonFinite {
                what: "scaled matrix",
                unknown: 0,
            }),
        }
    }

    fn solve(&mut self, b: &mut [f64]) -> Result<(), LinearError> {
        let Some(ready) = self.ready.as_mut().filter(|_| self.factorised) else {
            return Err(LinearError::NotReady { asked: "solve" });
        };
        check_length("right-hand side", ready.pattern.dim(), b.len())?;
        ready.gather(b);
        ready.substitute(false);
        let mut best = f64::INFINITY;
        for refinement in 0..=REFINEMENTS {
            let relative = ready.relative_residual(b)?;
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
            ready.substitute(true);
        }
        ready.scatter(b);
        Ok(())
    }
}

impl Ready {
    /// Scales for a matrix whose diagonal is no measure.
    fn equilibrate(&mut self, values: &[f64]) -> Result<(), LinearError> {
        // `x` and `residual` are free during a factorisation.
        scaling::equilibrate(&self.pattern, values, &mut self.x, &mut self.residual)?;
        for panel in &self.symbolic.panels {
            let from = &self.x[panel.unknown..panel.unknown + panel.size];
            self.scales[panel.first..panel.first + panel.size].copy_from_slice(from);
        }
        Ok(())
    }

    fn factorise(&mut self, values: &[f64], floor: f64, scaled: bool) -> Result<(), Failure> {
        let limit = rounding_level(self.symbolic.panels.len());
        self.squares.fill(0.0);
        self.smallest = f64::INFINITY;
        let (mut links, mut targets, mut loads, mut fills) = (0, 0, 0, 0);
        let mut read = 0;
        for k in 0..self.symbolic.panels.len() {
            let symbolic = &self.symbolic;
            let panel = &symbolic.panels[k];
            for load in &symbolic.loads[loads..panel.loads] {
                let copied = copy_block(
                    symbolic,
                    load,
                    values,
                    scaled,
                    &mut self.scales,
                    &mut self.squares,
                    [&mut self.matrix[read..], &mut self.factors[load.start..]],
                );
                let Some(count) = copied else {
                    return Err(Failure::Scale);
                };
                read += count;
            }
            for &(start, count) in &symbolic.fills[fills..panel.fills] {
                self.factors[start..start + count].fill(0.0);
            }
            let n = panel.size;
            let (left, right) = self.factors.split_at_mut(panel.end);
            let (d, below) = left[panel.start..].split_at_mut(n * n);
            let swaps = &mut self.swaps[panel.first..panel.first + n];
            let pivots = kernels::lu(n, d, swaps, floor);
            self.swapped[k] = pivots.swapped;
            self.smallest = self.smallest.min(pivots.smallest);
            if !(pivots.smallest > limit && pivots.largest < GROWTH_LIMIT) && floor == 0.0 {
                return Err(Failure::Error(name_pivot(panel.unknown, n, d, limit)));
            }
            let my_links = &symbolic.links[links..panel.links];
            let mut rest = &mut *below;
            for link in my_links {
                let (pair, others) = rest.split_at_mut(2 * link.size * n);
                let (l, ut) = pair.split_at_mut(link.size * n);
                finish_link(
                    symbolic.symmetry,
                    link.size,
                    n,
                    d,
                    l,
                    ut,
                    swaps,
                    pivots.swapped,
                );
                rest = others;
            }
            let offset = panel.start + n * n;
            let mut target = targets;
            for (a, row) in my_links.iter().enumerate() {
                for (b, column) in my_links.iter().enumerate() {
                    let start = symbolic.targets[target] as usize - panel.end;
                    target += 1;
                    let (l, ut) = (row.start - offset, column.start - offset);
                    let ut = ut + column.size * n;
                    if a >= b {
                        let c = &mut right[start..start + row.size * column.size];
                        kernels::update(row.size, column.size, n, c, &below[l..], &below[ut..]);
                    } else if symbolic.symmetry == Symmetry::General {
                        let c = &mut right[start..start + row.size * column.size];
                        kernels::update(column.size, row.size, n, c, &below[ut..], &below[l..]);
                    }
                }
            }
            (links, targets, loads, fills) = (panel.links, panel.targets, panel.loads, panel.fills);
        }
        let largest = self
            .symbolic
            .panels
            .iter()
            .zip(&self.squares)
            .fold(0.0_f64, |m, (panel, square)| {
                m.max(square * panel.blocks as f64)
            });
        self.norm = largest.sqrt();
        Ok(())
    }

    /// Scaled right-hand side in elimination order.
    fn gather(&mut self, b: &[f64]) {
        for panel in &self.symbolic.panels {
            let range = panel.first..panel.first + panel.size;
            let b = &b[panel.unknown..panel.unknown + panel.size];
            for ((y, b), s) in self.rhs[range.clone()]
                .iter_mut()
                .zip(b)
                .zip(&self.scales[range])
            {
                *y = b * s;
            }
        }
        self.residual.copy_from_slice(&self.rhs);
    }

    /// Solution with its scales undone, in the order of the matrix.
    fn scatter(&self, b: &mut [f64]) {
        for panel in &self.symbolic.panels {
            let range = panel.first..panel.first + panel.size;
            let b = &mut b[panel.unknown..panel.unknown + panel.size];
            for ((b, x), s) in b
                .iter_mut()
                .zip(&self.x[range.clone()])
                .zip(&self.scales[range])
            {
                *b = x * s;
            }
        }
    }

    /// Solves for the vector in `residual`, which is destroyed; into `x`, or added to it.
    fn substitute(&mut self, add: bool) {
        let symbolic = &self.symbolic;
        let y = &mut self.residual;
        let mut links = 0;
        for (k, panel) in symbolic.panels.iter().enumerate() {
            let n = panel.size;
            let (left, right) = y.split_at_mut(panel.first + n);
            let own = &mut left[panel.first..];
            if self.swapped[k] {
                for (i, &row) in self.swaps[panel.first..panel.first + n].iter().enumerate() {
                    own.swap(i, row as usize);
                }
            }
            kernels::solve_lower(n, &self.factors[panel.start..], own);
            for link in &symbolic.links[links..panel.links] {
                let later = &mut right[link.first - panel.first - n..];
                kernels::subtract(link.size, n, &self.factors[link.start..], own, later);
            }
            links = panel.links;
        }
        for k in (0..symbolic.panels.len()).rev() {
            let panel = &symbolic.panels[k];
            let n = panel.size;
            let (left, right) = y.split_at_mut(panel.first + n);
            let own = &mut left[panel.first..];
            for link in &symbolic.links[symbolic.links_of(k)] {
                let later = &right[link.first - panel.first - n..];
                let ut = &self.factors[link.start + link.size * n..];
                kernels::subtract_transposed(link.size, n, ut, later, own);
            }
            kernels::solve_upper(n, &self.factors[panel.start..], own);
        }
        if add {
            for (x, y) in self.x.iter_mut().zip(&self.residual) {
                *x += y;
            }
        } else {
            self.x.copy_from_slice(&self.residual);
        }
    }

    /// Computes `residual = rhs - A x` and its relative size.
    fn relative_residual(&mut self, b: &[f64]) -> Result<f64, LinearError> {
        let symbolic = &self.symbolic;
        let r = &mut self.residual;
        r.copy_from_slice(&self.rhs);
        let mut read = 0;
        for load in &symbolic.loads {
            let (row, column) = (&symbolic.panels[load.row], &symbolic.panels[load.column]);
            let (m, n) = (row.size, column.size);
            let block = &self.matrix[read..];
            kernels::subtract(m, n, block, &self.x[column.first..], &mut r[row.first..]);
            read += m * n;
            if load.row != load.column {
                let block = match symbolic.symmetry {
                    Symmetry::Symmetric => block,
                    Symmetry::General => {
                        read += m * n;
                        &block[m * n..]
                    }
                };
                let (x, y) = (&self.x[row.first..], &mut r[column.first..]);
                kernels::subtract_transposed(m, n, block, x, y);
            }
        }
        let (r, x, rhs) = (max_abs(r), max_abs(&self.x), max_abs(&self.rhs));
        let size = self.norm * x + rhs;
        if r <= f64::MAX && size <= f64::MAX {
            return Ok(if r == 0.0 { 0.0 } else { r / size });
        }
        if let Some(unknown) = first_non_finite(b) {
            return Err(LinearError::NonFinite {
                what: "right-hand side",
                unknown,
            });
        }
        let x = &self.x;
        let bad = |p: &super::symbolic::Panel| {
            first_non_finite(&x[p.first..p.first + p.size]).map(|i| p.unknown + i)
        };
        Err(LinearError::NonFinite {
            what: "solution",
            unknown: symbolic.panels.iter().find_map(bad).unwrap_or(0),
        })
    }

    /// Undoes scaling and order of the copy of the matrix; powers of two leave no trace.
    fn original(&self, values: &mut [f64]) {
        let symbolic = &self.symbolic;
        let mut read = 0;
        for load in &symbolic.loads {
            let (row, column) = (&symbolic.panels[load.row], &symbolic.panels[load.column]);
            let (m, n) = (row.size, column.size);
            let pair = symbolic.symmetry == Symmetry::General && load.row != load.column;
            let upper = if pair { m * n } else { 0 };
            for c in 0..n {
                for r in 0..m {
                    let scale = self.scales[row.first + r] * self.scales[column.first + c];
                    if load.row != load.column {
                        let value = self.matrix[read + upper + r + c * m];
                        values[load.upper + c + r * n] = value / scale;
                    }
                    values[load.lower + r + c * m] = self.matrix[read + r + c * m] / scale;
                }
            }
            read += m * n + upper;
        }
    }
}

/// Copies one block or pair with scales; the number of values, or none if they are out of scale.
#[inline(always)]
fn copy_block(
    symbolic: &Symbolic,
    load: &Load,
    values: &[f64],
    scaled: bool,
    scales: &mut [f64],
    squares: &mut [f64],
    [matrix, factors]: [&mut [f64]; 2],
) -> Option<usize> {
    let (row, column) = (&symbolic.panels[load.row], &symbolic.panels[load.column]);
    let (m, n) = (row.size, column.size);
    let lower = &values[load.lower..load.lower + m * n];
    if load.row == load.column {
        let s = &mut scales[row.first..row.first + n];
        if !scaled {
            for (c, s) in s.iter_mut().enumerate() {
                *s = scaling::inverse_root(lower[c * (n + 1)]);
            }
        }
        let square = kernels::scale(n, n, lower, s, s, matrix, factors);
        squares[load.row] += square;
        return (square <= scaling::MEAN_SQUARE_LIMIT * (n * n) as f64).then_some(n * n);
    }
    let (rows, columns) = (
        &scales[row.first..row.first + m],
        &scales[column.first..column.first + n],
    );
    let mut count = m * n;
    let mut square = kernels::scale(m, n, lower, rows, columns, matrix, factors);
    if symbolic.symmetry == Symmetry::General {
        let upper = &values[load.upper..load.upper + m * n];
        let (matrix, factors) = (&mut matrix[count..], &mut factors[count..]);
        square += kernels::scale_transposed(m, n, upper, rows, columns, matrix, factors);
        count *= 2;
    }
    squares[load.row] += square;
    squares[load.column] += square;
    (square <= scaling::MEAN_SQUARE_LIMIT * count as f64).then_some(count)
}

/// Turns the blocks of one link into those of `L` and `Uᵀ`.
#[allow(clippy::too_many_arguments)]
#[inline(always)]
fn finish_link(
    symmetry: Symmetry,
    m: usize,
    n: usize,
    d: &[f64],
    l: &mut [f64],
    ut: &mut [f64],
    swaps: &[u32],
    swapped: bool,
) {
    if symmetry == Symmetry::Symmetric {
        if !swapped {
            kernels::right_upper_pair(m, n, d, l, ut);
            return;
        }
        ut.copy_from_slice(l);
    }
    kernels::right_upper(m, n, d, l);
    if swapped {
        for (c, &other) in swaps.iter().enumerate() {
            let other = other as usize;
            if other != c {
                let (left, right) = ut.split_at_mut(other * m);
                left[c * m..(c + 1) * m].swap_with_slice(&mut right[..m]);
            }
        }
    }
    kernels::left_lower(m, n, d, ut);
}

/// Which pivot of a factorised diagonal block is to blame, and why.
#[cold]
fn name_pivot(unknown: usize, n: usize, d: &[f64], limit: f64) -> LinearError {
    let pivot = |c: usize| (1.0 / d[c * (n + 1)]).abs();
    for c in 0..n {
        if !(pivot(c) > limit) {
            return LinearError::VanishingPivot {
                unknown: unknown + c,
                pivot: pivot(c),
                limit,
            };
        }
    }
    let largest = (0..n).fold(0, |a, c| if pivot(c) > pivot(a) { c } else { a });
    LinearError::Growth {
        unknown: unknown + largest,
        growth: pivot(largest),
    }
}
