//! Errors of static analyses.

use crate::failure::{FailedStep, StepParameter};
use crate::linear_solver::LinearError;

/// Error of a static analysis.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
#[non_exhaustive]
pub enum StaticsError {
    /// An invalid option.
    #[error(
        "option {name} = {value:?} is not usable: it must be finite, steps positive, and tolerances at \
         most {}",
        super::StaticNewtonOptions::LOOSEST
    )]
    Option { name: &'static str, value: f64 },
    /// A vector of the wrong length.
    #[error("{what} has {found} entries; the system has {expected} unknowns")]
    Length {
        what: &'static str,
        found: usize,
        expected: usize,
    },
    /// An event that cannot occur.
    #[error("{0:?} cannot occur: its value must be finite, and its unknown one of the system")]
    Event(super::Event),
    /// There is no linear solver for the pattern.
    #[error("the linear solver cannot take this model: {source}")]
    Analysis { source: LinearError },
    /// Bifurcations of a system without a potential.
    #[error(
        "bifurcations are found by the number of unstable directions, which only symmetric tangents have: moments \
         and follower loads have no potential"
    )]
    Asymmetric,
    /// A bifurcation that a path should leave along another branch, of which there are several.
    #[error(
        "{directions} directions become unstable at or near the bifurcation at load parameter {}, so that there is no single \
         branch to go on along: take smaller steps, or hold the structure in one of the directions, by a support or \
         by more stiffness",
        crate::significant(*t)
    )]
    Multiple { t: f64, directions: usize },
    /// [`critical_point`](super::critical_point) has not converged.
    #[error(
        "no simple critical point is found from load parameter {}: {reason}; begin nearer to it, or give its shape",
        crate::significant(*t)
    )]
    NoCriticalPoint { t: f64, reason: String },
    /// A step failed down to the smallest step size.
    #[error("{0}")]
    Step(Box<FailedStep>),
}

impl StaticsError {
    /// The error of an analysis that advances another parameter than the load.
    pub fn of(mut self, parameter: StepParameter) -> Self {
        if let Self::Step(failed) = &mut self {
            failed.parameter = parameter;
        }
        self
    }
}
