//! The matrix of coupled stages.

use crate::linear_solver::{AutoSolver, LinearError, LinearSolver, MatrixSymmetry};
use pullback_manifold::sparse::BlockPattern;

/// The system's pattern with blocks for all stages of a node, one stage after the other, and its
/// solver.
pub(super) struct CoupledStages {
    /// Number of stages.
    count: usize,
    solver: AutoSolver,
    S: Vec<f64>,
    /// Position of each unknown of the system, for one stage after the other.
    positions: Vec<usize>,
    /// A right-hand side, then the solution, node by node.
    b: Vec<f64>,
}

impl CoupledStages {
    pub(super) fn new(pattern: &BlockPattern, count: usize) -> Result<Self, LinearError> {
        let sizes: Vec<usize> = (0..pattern.blocks())
            .map(|i| count * pattern.size(i))
            .collect();
        let pairs = (0..pattern.blocks())
            .flat_map(|j| pattern.column(j).map(move |(i, _)| [i as u32, j as u32]));
        let repeated = |i| std::iter::repeat_n(&pattern.coordinates()[pattern.unknowns(i)], count);
        let infos: Vec<_> = (0..pattern.blocks())
            .flat_map(repeated)
            .flatten()
            .copied()
            .collect();
        let all = BlockPattern::new(&sizes, pairs).with_coordinates(|i| infos[i]);
        let solver = AutoSolver::new(&all, MatrixSymmetry::General)?;
        let mut positions = Vec::with_capacity(all.dim());
        for stage in 0..count {
            for node in 0..pattern.blocks() {
                let start = all.unknowns(node).start + stage * pattern.size(node);
                positions.extend(start..start + pattern.size(node));
            }
        }
        Ok(Self {
            count,
            solver,
            S: vec![0.0; all.len()],
            b: vec![0.0; positions.len()],
            positions,
        })
    }

    /// Copies the derivative of the residual of stage `i` by the unknowns of stage `j`, in the
    /// system's pattern.
    pub(super) fn set(&mut self, pattern: &BlockPattern, [i, j]: [usize; 2], values: &[f64]) {
        for column in 0..pattern.blocks() {
            for (row, range) in pattern.column(column) {
                let (height, width) = (pattern.size(row), pattern.size(column));
                // Blocks are larger by count², in the same order.
                let first = range.start * self.count * self.count;
                let block = &values[range];
                for c in 0..width {
                    let to = first + (j * width + c) * self.count * height + i * height;
                    let from = &block[c * height..(c + 1) * height];
                    self.S[to..to + height].copy_from_slice(from);
                }
            }
        }
    }

    pub(super) fn factorise(&mut self) -> Result<(), LinearError> {
        let made = self.solver.factorise(&self.S);
        made.map_err(|error| self.explained(error))
    }

    /// Solves for the stages in `x`, one after the other.
    pub(super) fn solve(&mut self, x: &mut [f64]) -> Result<(), LinearError> {
        for (x, &position) in x.iter().zip(&self.positions) {
            self.b[position] = *x;
        }
        let solved = self.solver.solve(Some(&self.S), &mut self.b);
        solved.map_err(|error| self.explained(error))?;
        for (x, &position) in x.iter_mut().zip(&self.positions) {
            *x = self.b[position];
        }
        Ok(())
    }

    /// Renumbers an error to the system's unknowns.
    fn explained(&self, error: LinearError) -> LinearError {
        let n = self.positions.len() / self.count;
        error.renumbered(|unknown| {
            let known = self.positions.iter().position(|p| *p == unknown);
            known.map_or(unknown, |k| k % n)
        })
    }
}
