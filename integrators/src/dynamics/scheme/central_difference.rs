//! The explicit central difference.

use super::{Family, Scheme};

/// The central difference.
pub(super) const CENTRAL_DIFFERENCE: Family = Family {
    word: "central-difference",
    long: "central-difference",
    usage: "central-difference (explicit, stable for h of at most 2 / largest frequency)",
    stability: None,
    make: |numbers| numbers.is_empty().then(|| Ok(Scheme::central_difference())),
};

impl Scheme {
    /// The central difference in the form of Newmark's scheme with β = 0, γ = 1/2 (Hughes, *The
    /// Finite Element Method*, 9.1): coordinates are explicit, velocities trapezoidal. Of order 2,
    /// reversible, stable for ω h ≤ 2; a run refuses larger steps
    /// ([`DynamicsError::StepTooLarge`](crate::dynamics::DynamicsError)). The mass matrix is
    /// factorised, not lumped.
    pub fn central_difference() -> Self {
        let numbers = [0.0, 0.0, 0.0, 0.5];
        let word = "central-difference";
        let mut scheme = Self::newmark_form("central difference", word, [None; 2], numbers);
        scheme.properties.limit = Some(2.0);
        scheme
    }
}
