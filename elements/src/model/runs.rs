//! Unknowns and the coordinates of all nodes: the one vector from and to the other.

use std::ops::Range;

/// The coordinates that are unknowns, as runs without gaps: nearly all of a model is a single one,
/// and moves without a look at every number.
pub(super) struct Runs(Vec<Range<usize>>);

impl Runs {
    /// Of ascending coordinates.
    pub(super) fn new(coordinates: &[usize]) -> Self {
        let runs = coordinates.chunk_by(|a, b| a + 1 == *b);
        Self(runs.map(|run| run[0]..run[0] + run.len()).collect())
    }

    /// Values of the unknowns among those of all coordinates.
    pub(super) fn gather(&self, all: &[f64], unknowns: &mut [f64]) {
        let mut rest = unknowns;
        for run in &self.0 {
            let (own, others) = rest.split_at_mut(run.len());
            copy(&all[run.clone()], own);
            rest = others;
        }
    }

    /// The reverse; other coordinates stay as they are.
    pub(super) fn scatter(&self, unknowns: &[f64], all: &mut [f64]) {
        let mut rest = unknowns;
        for run in &self.0 {
            let (own, others) = rest.split_at(run.len());
            copy(own, &mut all[run.clone()]);
            rest = others;
        }
    }
}

/// Copies a run, that of a single frame without a call.
#[inline(always)]
fn copy(from: &[f64], to: &mut [f64]) {
    match (
        <&[f64; 6]>::try_from(from),
        <&mut [f64; 6]>::try_from(&mut *to),
    ) {
        (Ok(from), Ok(to)) => *to = *from,
        _ => to.copy_from_slice(from),
    }
}
