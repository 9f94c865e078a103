//! Which block of a matrix is wrong, and by how much.

use crate::layout::Layout;
use std::fmt;

/// A block of a matrix that is wrong: rows, columns, and how far it is off.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// The matrix: K, C, M, B_dot, ...
    pub matrix: String,
    /// Name of its rows.
    pub rows: String,
    /// Name of its columns; empty for a vector.
    pub columns: String,
    /// Norm of the difference between what was found and what is right (by differences).
    pub defect: f64,
    /// Norm of what is right.
    pub right: f64,
    /// What was found as a multiple of what is right, as closely as one number tells: 0.5 for a
    /// lost factor 2, −1 for a swapped sign, 0 for a missing term. Not a number where nothing
    /// belongs.
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

/// Blocks that are named for one law at most.
const MOST: usize = 3;
/// Blocks are named down to this fraction of the worst.
const NOTABLE: f64 = 0.1;

/// A matrix that was found beside the right one, in some of their columns.
#[derive(Clone, Debug)]
pub struct Compared<'a> {
    /// Its name.
    pub matrix: &'a str,
    /// What its rows are.
    pub rows: &'a Layout,
    /// What its columns are.
    pub columns: &'a Layout,
    /// Whether rows are forces (times their unit in energies) or coordinates (over it).
    pub forces: bool,
    /// Number of a column, the column found, the right one.
    pub values: Vec<(usize, Vec<f64>, Vec<f64>)>,
}

impl Compared<'_> {
    /// The blocks that are off most, when all are made comparable by the units.
    #[must_use]
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
                    let unit = if self.forces {
                        row.unit
                    } else {
                        1.0 / row.unit
                    };
                    let block = Block {
                        matrix: self.matrix.to_owned(),
                        rows: row.name.clone(),
                        columns: column.name.clone(),
                        defect: off.sqrt(),
                        right: right.sqrt(),
                        // Differences leave round-off where nothing belongs.
                        factor: if right > 1e-12 * off {
                            both / right
                        } else {
                            f64::NAN
                        },
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
pub fn difference(h: f64, mut f: impl FnMut(f64) -> Option<Vec<f64>>) -> Option<Vec<f64>> {
    let mut central = |h: f64| -> Option<Vec<f64>> {
        let (ahead, behind) = (f(h)?, f(-h)?);
        let pairs = ahead.iter().zip(&behind);
        Some(pairs.map(|(a, b)| (a - b) / (2.0 * h)).collect())
    };
    let (coarse, fine) = (central(h)?, central(0.5 * h)?);
    let pairs = coarse.iter().zip(&fine);
    Some(pairs.map(|(c, f)| (4.0 * f - c) / 3.0).collect())
}
