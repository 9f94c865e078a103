//! Errors of a matrix, block by block.

use crate::layout::Layout;
use std::fmt;

/// A wrong block of a matrix: its rows, its columns and its error.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// The matrix: K, C, M, B_dot, ...
    pub matrix: String,
    /// Name of its rows.
    pub rows: String,
    /// Name of its columns; empty for a vector.
    pub columns: String,
    /// Norm of the difference between the computed block and the correct one, which is found by differences.
    pub defect: f64,
    /// Norm of the correct block.
    pub right: f64,
    /// The multiple of the correct block that is closest to the computed one: 0.5 for a lost factor 2, −1 for a
    /// wrong sign, 0 for a missing term. NaN where the correct block is zero.
    pub factor: f64,
}

impl fmt::Display for Block {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            matrix,
            rows,
            columns,
            defect,
            right,
            factor,
        } = self;
        match columns.as_str() {
            "" => write!(f, "{matrix} of {rows}")?,
            _ => write!(f, "{matrix} (rows: {rows}; columns: {columns})")?,
        }
        write!(f, ": off by {defect:.3e}")?;
        if factor.is_nan() {
            write!(f, " where nothing belongs")
        } else {
            write!(
                f,
                ", {:.3} of its size {right:.3e}; it is {factor:.3} times what is right",
                defect / right
            )
        }
    }
}

/// Most blocks that are reported for one law.
const MOST: usize = 3;
/// Least error of a reported block over that of the worst one.
const NOTABLE: f64 = 0.1;

/// The layout of the rows of a matrix.
#[derive(Clone, Copy)]
pub(crate) enum Rows<'a> {
    /// Forces, whose energies are multiples of the unit.
    Forces(&'a Layout),
    /// Coordinates, which are divided by it.
    Coordinates(&'a Layout),
}

/// Number of a column, the computed column, the correct one.
pub(crate) type Column = (usize, Vec<f64>, Vec<f64>);

/// The blocks of a matrix with the largest errors, compared in units.
pub(crate) fn wrong_blocks(
    matrix: &str,
    rows: Rows<'_>,
    columns: &Layout,
    values: &[Column],
) -> Vec<Block> {
    let (Rows::Forces(layout) | Rows::Coordinates(layout)) = rows;
    let mut blocks: Vec<(f64, Block)> = Vec::new();
    for row in layout.groups() {
        for column in columns.groups() {
            let (mut off, mut right, mut both) = (0.0, 0.0, 0.0);
            let chosen = |c: &&Column| column.range.contains(&c.0);
            for (_, found, exact) in values.iter().filter(chosen) {
                for i in row.range.clone() {
                    off += (found[i] - exact[i]).powi(2);
                    right += exact[i].powi(2);
                    both += found[i] * exact[i];
                }
            }
            if off > 0.0 {
                let unit = match rows {
                    Rows::Forces(_) => row.unit,
                    Rows::Coordinates(_) => 1.0 / row.unit,
                };
                // Differences leave round-off where the correct block is zero.
                let known = right > 1e-12 * off;
                let block = Block {
                    matrix: matrix.to_owned(),
                    rows: row.name.clone(),
                    columns: column.name.clone(),
                    defect: off.sqrt(),
                    right: right.sqrt(),
                    factor: if known { both / right } else { f64::NAN },
                };
                blocks.push((off.sqrt() * unit * column.unit, block));
            }
        }
    }
    blocks.sort_by(|a, b| b.0.total_cmp(&a.0));
    let least = blocks.first().map_or(0.0, |b| NOTABLE * b.0);
    let notable = blocks.into_iter().take(MOST).filter(|b| b.0 >= least);
    notable.map(|b| b.1).collect()
}

/// The same of a vector.
pub(crate) fn wrong_entries(
    vector: &str,
    rows: Rows<'_>,
    found: &[f64],
    right: &[f64],
) -> Vec<Block> {
    let column = (0, found.to_vec(), right.to_vec());
    wrong_blocks(vector, rows, &Layout::single(), &[column])
}

/// The derivative of a vector at 0 by central differences with steps `h` and `h`/2, extrapolated;
/// `None` where `f` has no value.
pub(crate) fn difference(h: f64, mut f: impl FnMut(f64) -> Option<Vec<f64>>) -> Option<Vec<f64>> {
    let mut central = |h: f64| -> Option<Vec<f64>> {
        let (ahead, behind) = (f(h)?, f(-h)?);
        let pairs = ahead.iter().zip(&behind);
        Some(pairs.map(|(a, b)| (a - b) / (2.0 * h)).collect())
    };
    let (coarse, fine) = (central(h)?, central(0.5 * h)?);
    let pairs = coarse.iter().zip(&fine);
    Some(pairs.map(|(c, f)| (4.0 * f - c) / 3.0).collect())
}
