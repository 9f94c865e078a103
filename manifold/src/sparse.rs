//! Sparse matrices of dense blocks with a fixed pattern.
//!
//! A matrix is partitioned into blocks of consecutive unknowns (the free degrees of freedom of
//! one node, one joint coordinate, ...). The pattern lists which block pairs are nonzero; the
//! values of one block stand together in memory, column by column. A scalar sparse matrix is the
//! special case in which every block has size one.

use crate::coordinate::CoordinateInfo;
use nalgebra::{ComplexField, DMatrix};

/// The fixed, structurally symmetric pattern of a square block-sparse matrix.
///
/// Block columns are stored one after the other; within a block column, blocks come in ascending
/// block row, and the diagonal block is always present.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockPattern {
    /// First unknown of each block, and the total number of unknowns at the end.
    offsets: Vec<usize>,
    /// First entry of each block column in `rows`, and the number of blocks at the end.
    columns: Vec<usize>,
    /// Block row of each block.
    rows: Vec<u32>,
    /// First value of each block, and the number of values at the end.
    values: Vec<usize>,
    coordinates: Vec<CoordinateInfo>,
}

impl BlockPattern {
    /// Pattern of blocks of the given sizes, from groups of blocks that are coupled to each other.
    ///
    /// Each group (an element's nodes, say) makes a clique. Groups may repeat blocks.
    ///
    /// # Panics
    /// If a group has a block that is none of them.
    pub fn new<G>(sizes: &[usize], groups: G) -> Self
    where
        G: IntoIterator,
        G::Item: AsRef<[u32]>,
    {
        let groups: Vec<G::Item> = groups.into_iter().collect();
        let mut of_block: Vec<Vec<u32>> = vec![Vec::new(); sizes.len()];
        for (g, group) in groups.iter().enumerate() {
            for &i in group.as_ref() {
                of_block[i as usize].push(g as u32);
            }
        }
        // Last block column in which each block was seen.
        let mut seen = vec![usize::MAX; sizes.len()];
        let mut column = Vec::new();
        let mut offsets = vec![0];
        let mut columns = vec![0];
        let mut rows = Vec::new();
        let mut values = vec![0];
        let mut count = 0;
        for (j, of_block) in of_block.iter().enumerate() {
            offsets.push(offsets[j] + sizes[j]);
            seen[j] = j;
            column.clear();
            column.push(j as u32);
            for &i in of_block.iter().flat_map(|&g| groups[g as usize].as_ref()) {
                if std::mem::replace(&mut seen[i as usize], j) != j {
                    column.push(i);
                }
            }
            column.sort_unstable();
            for &i in &column {
                rows.push(i);
                count += sizes[i as usize] * sizes[j];
                values.push(count);
            }
            columns.push(rows.len());
        }
        Self {
            coordinates: vec![CoordinateInfo::default(); offsets[sizes.len()]],
            offsets,
            columns,
            rows,
            values,
        }
    }

    /// The same pattern with the kind of each unknown: [`CoordinateInfo::default`] without it.
    #[must_use]
    pub fn with_coordinates(self, info: impl FnMut(usize) -> CoordinateInfo) -> Self {
        let coordinates = (0..self.dim()).map(info).collect();
        Self {
            coordinates,
            ..self
        }
    }

    /// The kind of each unknown.
    pub fn coordinates(&self) -> &[CoordinateInfo] {
        &self.coordinates
    }

    /// A full matrix: one block of size `n`.
    pub fn dense(n: usize) -> Self {
        Self::new(&[n], [[0]])
    }

    /// Number of unknowns (rows, columns).
    pub fn dim(&self) -> usize {
        self.offsets[self.offsets.len() - 1]
    }

    /// Number of blocks along the diagonal.
    pub fn blocks(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Number of stored values.
    pub fn len(&self) -> usize {
        self.values[self.values.len() - 1]
    }

    /// Whether nothing is stored.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The unknowns of block `i`.
    pub fn unknowns(&self, i: usize) -> std::ops::Range<usize> {
        self.offsets[i]..self.offsets[i + 1]
    }

    /// Number of unknowns of block `i`.
    pub fn size(&self, i: usize) -> usize {
        self.offsets[i + 1] - self.offsets[i]
    }

    /// The blocks of block column `j`: block row and the range of its values, column by column.
    pub fn column(
        &self,
        j: usize,
    ) -> impl Iterator<Item = (usize, std::ops::Range<usize>)> + Clone + '_ {
        (self.columns[j]..self.columns[j + 1])
            .map(move |k| (self.rows[k] as usize, self.values[k]..self.values[k + 1]))
    }

    /// First value of the block in block row `i` and block column `j`, if it is in the pattern.
    ///
    /// Entry (r, c) of the block is at this index plus `r + c * size(i)`.
    pub fn find(&self, i: usize, j: usize) -> Option<usize> {
        let range = self.columns[j]..self.columns[j + 1];
        let k = self.rows[range.clone()].binary_search(&(i as u32)).ok()?;
        Some(self.values[range.start + k])
    }

    /// Index of the diagonal entry of each unknown among the values.
    pub fn diagonal(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.blocks()).flat_map(|j| {
            let (n, first) = (self.size(j), self.find(j, j));
            first
                .into_iter()
                .flat_map(move |first| (0..n).map(move |k| first + k * (n + 1)))
        })
    }

    /// Entries of the matrix with these values: row, column, value; column by column in each block. Fast with
    /// [`Iterator::for_each`].
    pub fn triplets<'a>(
        &'a self,
        values: &'a [f64],
    ) -> impl Iterator<Item = (usize, usize, f64)> + 'a {
        let of_column = |j| self.column(j).map(move |(i, range)| (i, j, range));
        let blocks = (0..self.blocks()).flat_map(of_column);
        blocks.flat_map(move |(i, j, range)| {
            let columns = values[range].chunks_exact(self.size(i).max(1));
            let columns = columns.zip(self.unknowns(j));
            columns.flat_map(move |(column, c)| {
                let entries = self.unknowns(i).zip(column);
                entries.map(move |(r, x)| (r, c, *x))
            })
        })
    }

    /// The matrix with these values.
    pub fn matrix(&self, values: &[f64]) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(self.dim(), self.dim());
        for (r, c, x) in self.triplets(values) {
            matrix[(r, c)] = x;
        }
        matrix
    }

    /// y ← y + α A x for the matrix of this pattern with the given values; x and y may be complex.
    pub fn multiply_add<T>(&self, alpha: f64, values: &[f64], x: &[T], y: &mut [T])
    where
        T: Copy + ComplexField<RealField = f64>,
    {
        for j in 0..self.blocks() {
            let x = &x[self.unknowns(j)];
            for (i, range) in self.column(j) {
                let (block, y) = (&values[range], &mut y[self.unknowns(i)]);
                match y.len() {
                    6 => add_block::<T, 6>(alpha, block, x, y),
                    _ => add_columns(alpha, block, x, y),
                }
            }
        }
    }
}

/// y ← y + α A x for a block of any height.
fn add_columns<T>(alpha: f64, block: &[f64], x: &[T], y: &mut [T])
where
    T: Copy + ComplexField<RealField = f64>,
{
    for (column, &x) in block.chunks_exact(y.len().max(1)).zip(x) {
        for (y, a) in y.iter_mut().zip(column) {
            *y += x.scale(alpha * a);
        }
    }
}

/// y ← y + α A x for a block of height H.
fn add_block<T, const H: usize>(alpha: f64, block: &[f64], x: &[T], y: &mut [T])
where
    T: Copy + ComplexField<RealField = f64>,
{
    let mut sum = [T::zero(); H];
    for (column, &x) in block.as_chunks::<H>().0.iter().zip(x) {
        for k in 0..H {
            sum[k] += x.scale(column[k]);
        }
    }
    for (y, sum) in y.iter_mut().zip(sum) {
        *y += sum.scale(alpha);
    }
}
