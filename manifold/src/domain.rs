//! The domain of a map, a joint or an element.

use std::f64::consts::TAU;

/// Default limit of a domain in messages: a rotation vector of a whole turn, mostly because the step was too large.
pub const CHART_EDGE: &str = "the range of its coordinates";

/// Largest angle of a rotation vector that is used: its tangent map T is singular at 2π, and T⁻¹ unbounded.
pub const LARGEST_ANGLE: f64 = TAU - 1e-3;

/// Why a point is outside of a domain.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DomainError {
    /// It is beyond this limit.
    #[error("it left {limit}")]
    Beyond {
        /// Words that follow "the joint left", with a remedy unless it is [`CHART_EDGE`].
        limit: &'static str,
        /// Distance to the limit, ≤ 0.
        margin: f64,
    },
    /// There is no value, for this reason: words that follow "joint at node a: ".
    #[error("{0}")]
    Undefined(String),
}

impl DomainError {
    /// The margin of a point that is inside, its distance to the limit; otherwise the error.
    ///
    /// # Errors
    /// [`DomainError::Beyond`] for a margin that is not positive.
    pub fn within(margin: f64, limit: &'static str) -> Result<f64, Self> {
        match margin > 0.0 {
            true => Ok(margin),
            false => Err(Self::Beyond { limit, margin }),
        }
    }

    /// The error of a joint, node or element of this name, in words.
    pub fn of(&self, what: &str) -> String {
        match self {
            Self::Beyond { limit, .. } if *limit == CHART_EDGE => {
                format!(
                    "{what} left {limit}: it moved or turned too far in one step, or a rotation of which only a part \
                     is held or prescribed came near a whole turn; take smaller steps, or hold or prescribe the \
                     rest of that rotation"
                )
            }
            Self::Beyond { limit, .. } => format!("{what} left {limit}"),
            Self::Undefined(why) => format!("{what}: {why}"),
        }
    }
}
