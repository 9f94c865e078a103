//! The numeric phase of the block LU: loops over panels at positions found beforehand.

use pullback_manifold::sparse::BlockPattern;

use super::symbolic::{BlockCopy, Symbolic};
use super::{LinearError, MatrixSymmetry, kernels, rounding_level, scaling};

/// Ratio of a pivot to the entries of the scaled matrix that counts as growth.
const GROWTH_LIMIT: f64 = 1e8;

/// Storage of a factorisation, made once.
pub(super) struct Factors {
    pub pattern: BlockPattern,
    pub symbolic: Symbolic,
    pub factors: Vec<f64>,
    /// Interchanges inside the diagonal blocks, in elimination order.
    pub swaps: Vec<u32>,
    pub swapped: Vec<bool>,
    /// Scales in elimination order.
    pub scales: Vec<f64>,
    /// Sum of squares of each block row and column.
    pub squares: Vec<f64>,
    pub norm: f64,
    /// The right-hand side, then the solution.
    pub y: Vec<f64>,
    pub rhs: Vec<f64>,
    pub x: Vec<f64>,
    /// `x` with its scales undone.
    pub unscaled: Vec<f64>,
}

impl Factors {
    /// Storage for factors of this structure.
    pub fn new(pattern: &BlockPattern, symbolic: Symbolic) -> Self {
        let n = pattern.dim();
        let panels = symbolic.panels.len();
        Self {
            pattern: pattern.clone(),
            factors: vec![0.0; symbolic.len],
            swaps: vec![0; n],
            swapped: vec![false; panels],
            scales: vec![1.0; n],
            squares: vec![0.0; panels],
            norm: 0.0,
            y: vec![0.0; n],
            rhs: vec![0.0; n],
            x: vec![0.0; n],
            unscaled: vec![0.0; n],
            symbolic,
        }
    }

    /// Equilibrates a matrix whose diagonal is not a scale.
    pub fn equilibrate(&mut self, values: &[f64]) -> Result<(), LinearError> {
        // `x` and `unscaled` are free during a factorisation.
        scaling::equilibrate(&self.pattern, values, &mut self.x, &mut self.unscaled)?;
        for panel in &self.symbolic.panels {
            let from = &self.x[panel.unknown..panel.unknown + panel.size];
            self.scales[panel.first..panel.first + panel.size].copy_from_slice(from);
        }
        Ok(())
    }

    /// Factorises the matrix with these values. A right-hand side `b` is scaled into `y` and
    /// substituted through the lower factor at the same time, while the factors are in cache. False if
    /// entries are out of scale.
    pub fn factorise(
        &mut self,
        values: &[f64],
        scaled: bool,
        b: Option<&[f64]>,
    ) -> Result<bool, LinearError> {
        let limit = rounding_level(self.symbolic.panels.len());
        self.squares.fill(0.0);
        if b.is_some() {
            self.y.fill(0.0);
        }
        for k in 0..self.symbolic.panels.len() {
            if !self.load(k, values, scaled) {
                return Ok(false);
            }
            self.factorise_diagonal(k, limit)?;
            self.finish_panel(k);
            self.update_later(k);
            if let Some(b) = b {
                self.substitute_forward(k, b);
            }
        }
        let squares = self.symbolic.panels.iter().zip(&self.squares);
        let largest = squares.fold(0.0_f64, |m, (panel, square)| {
            m.max(square * panel.blocks as f64)
        });
        self.norm = largest.sqrt();
        Ok(true)
    }

    /// Copies the blocks of the matrix that panel `k` is the first to need, with their scales;
    /// false if they are out of scale.
    #[inline(always)]
    fn load(&mut self, k: usize, values: &[f64], scaled: bool) -> bool {
        let symbolic = &self.symbolic;
        for load in &symbolic.loads[symbolic.span(k, |panel| panel.loads)] {
            let factors = &mut self.factors[load.start..];
            let (scales, squares) = (&mut self.scales, &mut self.squares);
            if !copy_block(symbolic, load, values, scaled, scales, squares, factors) {
                return false;
            }
        }
        for &(start, count) in &symbolic.fills[symbolic.span(k, |panel| panel.fills)] {
            self.factors[start..start + count].fill(0.0);
        }
        true
    }

    /// Factorises the diagonal block of panel `k`.
    #[inline(always)]
    fn factorise_diagonal(&mut self, k: usize, limit: f64) -> Result<(), LinearError> {
        let panel = &self.symbolic.panels[k];
        let n = panel.size;
        let d = &mut self.factors[panel.start..panel.start + n * n];
        let swaps = &mut self.swaps[panel.first..panel.first + n];
        let pivots = kernels::lu(n, d, swaps);
        self.swapped[k] = pivots.swapped;
        if !(pivots.smallest > limit && pivots.largest < GROWTH_LIMIT) {
            return Err(name_pivot(panel.unknown, n, d, limit));
        }
        Ok(())
    }

    /// Transforms the other blocks of panel `k` to those of `L` and `Uᵀ`.
    #[inline(always)]
    fn finish_panel(&mut self, k: usize) {
        let symbolic = &self.symbolic;
        let panel = &symbolic.panels[k];
        let links = &symbolic.links[symbolic.links_of(k)];
        let n = panel.size;
        let (d, below) = self.factors[panel.start..panel.end].split_at_mut(n * n);
        let swaps = &self.swaps[panel.first..panel.first + n];
        let mut rest = below;
        for link in links {
            let (pair, others) = rest.split_at_mut(2 * link.size * n);
            let (l, ut) = pair.split_at_mut(link.size * n);
            let swapped = self.swapped[k];
            finish_link(symbolic.symmetry, link.size, n, d, l, ut, swaps, swapped);
            rest = others;
        }
    }

    /// Subtracts the products of the blocks of panel `k` from those of later panels.
    #[inline(always)]
    fn update_later(&mut self, k: usize) {
        let symbolic = &self.symbolic;
        let panel = &symbolic.panels[k];
        let links = &symbolic.links[symbolic.links_of(k)];
        let n = panel.size;
        let (left, right) = self.factors.split_at_mut(panel.end);
        let below = &left[panel.start + n * n..];
        let offset = panel.start + n * n;
        let targets = &symbolic.targets[symbolic.span(k, |panel| panel.targets)];
        let mut targets = targets.iter().map(|&target| target as usize - panel.end);
        for (a, row) in links.iter().enumerate() {
            for ((b, column), start) in links.iter().enumerate().zip(&mut targets) {
                let (l, ut) = (row.start - offset, column.start - offset);
                let ut = ut + column.size * n;
                if a >= b {
                    let c = &mut right[start..start + row.size * column.size];
                    kernels::update(row.size, column.size, n, c, &below[l..], &below[ut..]);
                } else if symbolic.symmetry == MatrixSymmetry::General {
                    let c = &mut right[start..start + row.size * column.size];
                    kernels::update(column.size, row.size, n, c, &below[ut..], &below[l..]);
                }
            }
        }
    }

    /// Scales the right-hand side of panel `k` into `y` and substitutes it through the lower factor.
    #[inline(always)]
    fn substitute_forward(&mut self, k: usize, b: &[f64]) {
        let panel = &self.symbolic.panels[k];
        let own = panel.first..panel.first + panel.size;
        let b = &b[panel.unknown..panel.unknown + panel.size];
        for (i, b) in own.zip(b) {
            self.y[i] += b * self.scales[i];
        }
        self.forward(k);
    }
}

/// Copies one block or pair with scales; false if they are out of scale.
#[inline(always)]
fn copy_block(
    symbolic: &Symbolic,
    load: &BlockCopy,
    values: &[f64],
    scaled: bool,
    scales: &mut [f64],
    squares: &mut [f64],
    factors: &mut [f64],
) -> bool {
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
        let square = kernels::scale::<false>(n, n, lower, s, s, factors);
        squares[load.row] += square;
        return square <= scaling::MEAN_SQUARE_LIMIT * (n * n) as f64;
    }
    let (rows, columns) = (
        &scales[row.first..row.first + m],
        &scales[column.first..column.first + n],
    );
    let mut count = m * n;
    let mut square = kernels::scale::<false>(m, n, lower, rows, columns, factors);
    if symbolic.symmetry == MatrixSymmetry::General {
        let upper = &values[load.upper..load.upper + m * n];
        square += kernels::scale::<true>(m, n, upper, rows, columns, &mut factors[count..]);
        count *= 2;
    }
    squares[load.row] += square;
    squares[load.column] += square;
    square <= scaling::MEAN_SQUARE_LIMIT * count as f64
}

/// Transforms the blocks of one link into those of `L` and `Uᵀ`.
#[allow(clippy::too_many_arguments, reason = "a private step of one algorithm")]
#[inline(always)]
fn finish_link(
    symmetry: MatrixSymmetry,
    m: usize,
    n: usize,
    d: &[f64],
    l: &mut [f64],
    ut: &mut [f64],
    swaps: &[u32],
    swapped: bool,
) {
    if symmetry == MatrixSymmetry::Symmetric {
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

/// The bad pivot of a factorised diagonal block, and its error.
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
