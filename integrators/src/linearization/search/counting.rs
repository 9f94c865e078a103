//! Numbers of eigenvalues by Sylvester's law of inertia.

use super::selection::squares;
use super::{EQUAL, Inner, MARGIN, ModesError, RitzPair, Search, Selection};

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
    ) -> usize {
        if !self.is_symmetric() || wanted == 0 {
            return 0;
        }
        if let Selection::Range(_) = self.selection {
            let inside = self.inside(&pairs[..converged]);
            return expected.map_or(0, |expected| expected.saturating_sub(inside));
        }
        let shift = self.operator.shift();
        // Nor is any below a lower shift.
        let lowest = self.inner == Inner::Mass && self.operator.below() == Some(0);
        let found = |radius: f64| {
            let near = pairs[..converged].iter();
            near.filter(|p| p.theta.norm() * radius >= 1.0).count()
        };
        // `None` beside an eigenvalue that is zero but for rounding errors as well.
        let mut count = |radius: f64| -> Option<usize> {
            let below = match lowest {
                true => Some(0),
                false => self.below(shift - radius).ok()?,
            };
            let up_to = self.below(shift + radius).ok()?;
            up_to.zip(below).map(|(up_to, below)| match self.inner {
                // Eigenvalues of both signs, from zero on.
                Inner::Stiffness => up_to + below,
                _ => up_to.saturating_sub(below),
            })
        };
        let last = pairs[wanted - 1].theta.norm().recip();
        let mut radius = last * (1.0 + MARGIN);
        *expected = count(radius);
        let others = expected.map_or(0, |expected| expected.saturating_sub(found(radius)));
        if others == 0 {
            return 0;
        }
        // Of copies of the last frequency, as many as are requested are enough.
        radius = last * (1.0 - EQUAL);
        let nearer = count(radius).map_or(0, |count| count.saturating_sub(found(radius)));
        let short = self.selection.most().saturating_sub(converged);
        nearer.min(wanted).max(others.min(short))
    }
}
