//! Numbers of eigenvalues by Sylvester's law of inertia.

use super::selection::squares;
use super::{Inner, MARGIN, ModesError, RitzPair, Search, Selection};

/// Most halvings of a range towards the modes in it.
const HALVINGS: usize = 24;
/// Part of a range at which it is divided.
const MIDDLE: f64 = 0.47;

impl Search<'_> {
    /// Number of eigenvalues in the range, if there is one and they can be counted. The shift is set to the middle
    /// of the part of the range that holds them.
    pub(super) fn number_in_range(&mut self) -> Result<Option<usize>, ModesError> {
        let Selection::Range(range) = self.selection else {
            return Ok(None);
        };
        if !self.is_symmetric() {
            return Ok(None);
        }
        let [mut from, mut to] = squares(range);
        let (Some(below), Some(up_to)) = (self.below(from)?, self.below(to)?) else {
            return Ok(None);
        };
        let mut count = up_to.saturating_sub(below);
        if below > 0 {
            // Modes that grow have ω² < 0.
            let inner = self.below(-from.abs())?;
            let outer = if inner == Some(0) {
                inner
            } else {
                self.below(-to)?
            };
            let (Some(inner), Some(outer)) = (inner, outer) else {
                return Ok(None);
            };
            count += inner.saturating_sub(outer);
        }
        // Not where a symmetric structure may have an eigenvalue.
        self.middle = from + MIDDLE * (to - from);
        if up_to == below {
            return Ok(Some(count));
        }
        for _ in 0..HALVINGS {
            match self.below(self.middle)? {
                Some(half) if half == below => from = self.middle,
                Some(half) if half == up_to => to = self.middle,
                _ => break,
            }
            self.middle = from + MIDDLE * (to - from);
        }
        Ok(Some(count))
    }

    /// Number of eigenvalues below a limit, if they can be counted.
    pub(super) fn below(&mut self, limit: f64) -> Result<Option<usize>, ModesError> {
        self.factorise_near(limit)?;
        Ok(self.operator.below())
    }

    /// Number of eigenvalues near the shift beyond the pairs found.
    pub(super) fn missing(
        &mut self,
        pairs: &[RitzPair],
        converged: usize,
        wanted: usize,
        expected: &mut Option<usize>,
    ) -> Result<usize, ModesError> {
        if let Selection::Range(_) = self.selection {
            let inside = self.inside(&pairs[..converged]);
            return Ok(expected.map_or(0, |expected| expected.saturating_sub(inside)));
        }
        let shift = self.operator.shift();
        let radius = pairs[wanted - 1].theta.norm().recip() * (1.0 + MARGIN);
        let near = pairs[..converged]
            .iter()
            .filter(|p| p.theta.norm() * radius >= 1.0);
        let found = near.count();
        let below = match self.inner {
            // Nor is any below a lower shift.
            Inner::Mass if self.operator.below() == Some(0) => Some(0),
            _ => self.below(shift - radius)?,
        };
        let up_to = self.below(shift + radius)?;
        *expected = up_to.zip(below).map(|(up_to, below)| match self.inner {
            // Eigenvalues of both signs, from zero on.
            Inner::Stiffness => up_to + below,
            _ => up_to.saturating_sub(below),
        });
        Ok(expected.map_or(0, |expected| expected.saturating_sub(found)))
    }
}
