//! Equilibrium: load stepping and path following for any
//! [`System`](pullback_manifold::system::System) at rest.
//!
//! A step reads as verbs: change charts, evaluate, predict, correct, accept. The step size is
//! halved after a failure and grows after an easy step.

#![allow(non_snake_case)]

mod arc_length;
mod error;
mod fixed_load;
mod load_steps;
mod locate;
mod newton;
mod path;
mod path_run;
mod stability;
mod start;

pub use crate::failure::{Cause, Cost, FailedStep, StepParameter};
pub use error::StaticsError;
pub use load_steps::{
    LoadSteps, StaticOptions, StaticSummary, equilibrium, solve_statics, solve_statics_with,
};
pub use path::{ArcLengthOptions, Event, PathSteps, PathSummary, trace_path, trace_path_with};

/// Options of Newton's method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StaticNewtonOptions {
    /// Residual relative to applied and reaction forces (moments) at convergence; positive,
    /// [`StaticNewtonOptions::LOOSEST`] at most.
    pub relative: f64,
    /// Absolute tolerance of the same test, in units of force (moment); 0 allows only rounding errors.
    pub absolute: f64,
    /// Largest number of linear solutions per step.
    pub max_iterations: usize,
    /// Number of full corrections at the beginning of a step; later ones are damped if they do not
    /// approach the solution.
    pub full_corrections: usize,
    /// A step that needs a smaller damping factor fails.
    pub smallest_damping: f64,
}

impl Default for StaticNewtonOptions {
    fn default() -> Self {
        Self {
            relative: 1e-9,
            absolute: 0.0,
            max_iterations: 20,
            full_corrections: 6,
            smallest_damping: 1.0 / 16.0,
        }
    }
}

impl StaticNewtonOptions {
    /// Largest [`StaticNewtonOptions::relative`].
    pub const LOOSEST: f64 = 0.1;

    /// An invalid tolerance, with its name.
    fn refused(&self) -> Option<(&'static str, f64)> {
        refused(self.relative, self.absolute)
    }
}

/// The first invalid tolerance of Newton's method, with its name.
pub(crate) fn refused(relative: f64, absolute: f64) -> Option<(&'static str, f64)> {
    if !(relative > 0.0 && relative <= StaticNewtonOptions::LOOSEST) {
        return Some(("newton.relative", relative));
    }
    let usable = absolute >= 0.0 && absolute.is_finite();
    (!usable).then_some(("newton.absolute", absolute))
}

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

/// Report of a converged step, for observers.
#[derive(Clone, Copy, Debug)]
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

/// An equilibrium that a step has reached.
#[derive(Clone, Copy, Default)]
struct Converged {
    number: usize,
    t: f64,
    step_size: f64,
    iterations: usize,
    chart_changes: usize,
    unstable: Option<usize>,
}

impl Converged {
    /// The report of the step.
    fn report<'a>(&self, q: &'a [f64], residuals: &'a [Iteration]) -> Step<'a> {
        Step {
            number: self.number,
            t: self.t,
            step_size: self.step_size,
            q,
            iterations: self.iterations,
            residuals,
            chart_changes: self.chart_changes,
            event: None,
            unstable: self.unstable,
        }
    }
}
