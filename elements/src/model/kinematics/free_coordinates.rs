//! Transfer between the vectors of unknowns and of all coordinates.

use crate::model::Model;
use pullback_manifold::system::SystemError;

/// All vectors of callers pass through here, with a check of their length.
impl Model {
    /// Gathers the values of the unknowns from those of all coordinates.
    pub(in crate::model) fn gather(
        &self,
        all: &[f64],
        what: &'static str,
        unknowns: &mut [f64],
    ) -> Result<(), SystemError> {
        check_length(what, self.coordinates.len(), unknowns.len())?;
        for (own, &c) in unknowns.iter_mut().zip(&self.coordinates) {
            *own = all[c];
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
        check_length(what, self.coordinates.len(), unknowns.len())?;
        for (own, &c) in unknowns.iter().zip(&self.coordinates) {
            all[c] = *own;
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
