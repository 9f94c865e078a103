//! Why a static analysis failed.

use crate::failure::FailedStep;
use crate::linear_solver::LinearError;

/// Why a static analysis failed.
#[derive(Debug, thiserror::Error)]
pub enum StaticsError {
    /// An option that makes no sense.
    #[error(
        "option {name} = {value:?} is not usable: it must be finite, steps positive, and tolerances at \
         most {}",
        super::NewtonOptions::LOOSEST
    )]
    Option {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// The structure of the equations could not be analysed.
    #[error("the linear solver cannot take this model: {source}")]
    Analysis {
        /// Its reason.
        source: LinearError,
    },
    /// A step failed down to the smallest step size.
    #[error("{0}")]
    Step(Box<FailedStep>),
}
