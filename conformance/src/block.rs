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

/// Columns of a matrix beside the correct ones.
pub(crate) struct Compared<'a> {
    /// Name of the matrix.
    pub matrix: &'a str,
    pub rows: &'a Layout,
    pub columns: &'a Layout,
    /// Whether rows are forces, whose energies are multiples of the unit, or coordinates, which are divided by it.
    pub forces: bool,
    /// Number of a column, the computed column, the correct one.
    pub values: Vec<(usize, Vec<f64>, Vec<f64>)>,
}

impl Compared<'_> {
    /// The blocks of a vector of forces with the largest errors.
    pub fn forces(matrix: &str, rows: &Layout, found: &[f64], right: &[f64]) -> Vec<Block> {
        let compared = Compared {
            matrix,
            rows,
            columns: &Layout::single(),
            forces: true,
            values: vec![(0, found.to_vec(), right.to_vec())],
        };
        compared.worst()
    }

    /// The blocks with the largest errors, compared in units.
    pub fn worst(&self) -> Vec<Block> {
        let mut blocks: Vec<(f64, Block)> = Vec::new();
        for row in self.rows.groups() {
            for column in self.columns.groups() {
                let (mut off, mut right, mut both) = (0.0, 0.0, 0.0);
                let chosen = |c: &&(usize, Vec<f64>, Vec<f64>)| column.range.contains(&c.0);
                for (_, found, exact) in self.values.iter().filter(chosen) {
                    for i in row.range.clone() {
                        off += (found[i] - exact[i]).powi(2);
                        right += exact[i].powi(2);
                        both += found[i] * exact[i];
                    }
                }
                if off > 0.0 {
                    let unit = match self.forces {
                        true => row.unit,
                        false => 1.0 / row.unit,
                    };
                    // Differences leave round-off where the correct block is zero.
                    let known = right > 1e-12 * off;
                    let block = Block {
                        matrix: self.matrix.to_owned(),
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
