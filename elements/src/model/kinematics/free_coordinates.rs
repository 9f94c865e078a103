//! Transfer between the vectors of unknowns and of all coordinates.

use super::node_entries::copy;
use pullback_manifold::system::SystemError;
use std::ops::Range;

/// The coordinates that are unknowns, as contiguous runs: most of a model is a single one, copied
/// as a block.
///
/// All vectors of callers pass through here, with a check of their length.
#[derive(Clone)]
pub(in crate::model) struct FreeCoordinates {
    runs: Vec<Range<usize>>,
    unknowns: usize,
}

impl FreeCoordinates {
    /// From ascending coordinates.
    pub(in crate::model) fn new(coordinates: &[usize]) -> Self {
        let runs = coordinates.chunk_by(|a, b| a + 1 == *b);
        Self {
            runs: runs.map(|run| run[0]..run[0] + run.len()).collect(),
            unknowns: coordinates.len(),
        }
    }

    /// Gathers the values of the unknowns from those of all coordinates.
    pub(in crate::model) fn gather(
        &self,
        all: &[f64],
        what: &'static str,
        unknowns: &mut [f64],
    ) -> Result<(), SystemError> {
        check_length(what, self.unknowns, unknowns.len())?;
        let mut rest = unknowns;
        for run in &self.runs {
            let (own, others) = rest.split_at_mut(run.len());
            copy(&all[run.clone()], own);
            rest = others;
        }
        Ok(())
    }

    /// The reverse; other coordinates are unchanged.
    pub(in crate::model) fn scatter(
        &self,
        what: &'static str,
        unknowns: &[f64],
        all: &mut [f64],
    ) -> Result<(), SystemError> {
        check_length(what, self.unknowns, unknowns.len())?;
        let mut rest = unknowns;
        for run in &self.runs {
            let (own, others) = rest.split_at(run.len());
            copy(own, &mut all[run.clone()]);
            rest = others;
        }
        Ok(())
    }
}

/// Rejects a slice of the wrong length.
pub(in crate::model) fn check_length(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), SystemError> {
    if found == expected {
        return Ok(());
    }
    Err(SystemError::Request {
        what,
        expected: format!("{expected} entries"),
        found: found.to_string(),
    })
}
