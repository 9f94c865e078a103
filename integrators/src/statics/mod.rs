//! Equilibrium: load stepping and path following for any
//! [`System`](pullback_manifold::system::System) at rest.
//!
//! A step changes charts, evaluates the system, predicts, corrects and accepts. Its size is halved
//! after a failure and grows after a step of few iterations.

mod arc_length;
mod critical;
mod error;
mod fixed_load;
mod load_run;
mod locate;
mod newton;
mod options;
mod path_attempt;
mod path_run;
mod stability;
mod start;
mod steps;

pub use crate::failure::{Cause, FailedStep, StepParameter};
pub use critical::{CriticalKind, CriticalPoint, PathDirection, critical_point};
pub use error::StaticsError;
pub(crate) use options::refused;
pub use options::{ArcLengthOptions, Event, StaticNewtonOptions, StaticOptions};
pub(crate) use stability::enforced_equations;
pub(crate) use steps::equilibrium_from;
pub use steps::{LoadSteps, PathSteps, Steps, equilibrium, solve_statics, trace_path};

/// One Newton iteration of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iteration {
    /// Largest residual per quantity of coordinate: force, moment, other.
    pub residual: [f64; 3],
    /// The largest of them relative to the tolerance.
    pub ratio: f64,
    /// Largest entry of the correction, relative to the scale of its coordinate.
    pub correction: f64,
    /// Part of the correction that was applied.
    pub damping: f64,
}

/// Number of linear solutions in a history.
pub(crate) fn solutions(history: &[Iteration]) -> usize {
    history.iter().filter(|i| i.damping > 0.0).count()
}

/// Report of a converged step, for observers.
#[derive(Clone, Copy, Debug, Default)]
pub struct Step<'a> {
    /// Number of the step, from 1; located events have the number of their step. 0 is the
    /// equilibrium under the loads at the start, if there are any.
    pub number: usize,
    /// Load parameter.
    pub t: f64,
    /// Step in the load parameter, or along the path.
    pub step_size: f64,
    /// Coordinates in the charts of this step.
    pub q: &'a [f64],
    /// Linear solutions of this step, predictor included; for a located event those that located
    /// it, and at the end of a path also those of its step.
    pub iterations: usize,
    /// History of the iterations; the last entry is the converged state.
    pub residuals: &'a [Iteration],
    /// Charts changed at the beginning of the step.
    pub chart_changes: usize,
    /// Index of the event located here, if any.
    pub event: Option<usize>,
    /// Number of unstable directions of the equilibrium: negative eigenvalues of the tangent at
    /// this state, less one for each equation with a multiplier. `None` if the tangent is not
    /// symmetric or is singular, as at a turning point, or if the solver does not provide it.
    pub unstable: Option<usize>,
}

/// Counters and results of an analysis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StaticSummary {
    /// Load parameter reached.
    pub t: f64,
    /// Converged steps.
    pub steps: usize,
    /// Failed attempts.
    pub rejected: usize,
    /// Linear solutions in converged steps.
    pub iterations: usize,
    /// Evaluations of the system.
    pub evaluations: usize,
    /// Factorisations.
    pub factorisations: usize,
    /// Changes of chart.
    pub chart_changes: usize,
    /// Whether the end of the load, or an ending event of a path, was reached (an observer may stop earlier).
    pub finished: bool,
}
