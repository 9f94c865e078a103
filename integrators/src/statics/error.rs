//! Errors of static analyses.

use crate::failure::FailedStep;
use crate::linear_solver::LinearError;

/// Error of a static analysis.
#[derive(Debug, thiserror::Error)]
pub enum StaticsError {
    /// An invalid option.
    #[error(
        "option {name} = {value:?} is not usable: it must be finite, steps positive, and tolerances at \
         most {}",
        super::StaticNewtonOptions::LOOSEST
    )]
    Option {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// The linear solver cannot analyse the pattern.
    #[error("the linear solver cannot take this model: {source}")]
    Analysis {
        /// The error of the solver.
        source: LinearError,
    },
    /// A step failed down to the smallest step size.
    #[error("{0}")]
    Step(Box<FailedStep>),
}
