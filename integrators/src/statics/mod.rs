//! Equilibrium: load stepping and path following for any
//! [`System`](pullback_manifold::system::System) at rest.
//!
//! A step reads as verbs: change charts, evaluate, predict, correct, accept. The step size is
//! halved when a step fails and grows when it was easy, so that a load in gives an answer out.

#![allow(non_snake_case)]

mod arc_length;
mod error;
mod load_steps;
mod locate;
mod newton;
mod path;
mod stability;
mod start;

pub use crate::failure::{Cause, Cost, FailedStep, StepParameter};
pub use arc_length::{trace_path, trace_path_with};
pub use error::StaticsError;
pub use load_steps::{StaticOptions, Summary, equilibrium, solve_statics, solve_statics_with};
pub use path::{ArcLengthOptions, Event, PathSummary};

/// Newton's method: when to stop and how far to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonOptions {
    /// Residual relative to applied and reaction forces (moments) at which a step has converged;
    /// positive, [`NewtonOptions::LOOSEST`] at most.
    pub relative: f64,
    /// Absolute floor of the same test, in units of force (moment); 0 leaves only rounding errors
    /// unmended, whatever the size of the model.
    pub absolute: f64,
    /// Linear solutions per step at most.
    pub max_iterations: usize,
    /// Corrections at the beginning of a step that are made in full; later ones are damped when
    /// they do not approach the solution.
    pub full_corrections: usize,
    /// A step that needs a smaller damping factor has failed.
    pub smallest_damping: f64,
}

impl Default for NewtonOptions {
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

impl NewtonOptions {
    /// Largest [`NewtonOptions::relative`]: more than that out of balance is no equilibrium.
    pub const LOOSEST: f64 = 0.1;

    /// A tolerance that makes no sense, with its name.
    fn refused(&self) -> Option<(&'static str, f64)> {
        refused(self.relative, self.absolute)
    }
}

/// Tolerances of Newton's method that make no sense, the first with its name.
pub(crate) fn refused(relative: f64, absolute: f64) -> Option<(&'static str, f64)> {
    if !(relative > 0.0 && relative <= NewtonOptions::LOOSEST) {
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
    /// The worst of them over what the convergence test allows.
    pub ratio: f64,
    /// Largest entry of the correction, relative to the scale of its coordinate.
    pub correction: f64,
    /// Part of the correction that was made.
    pub damping: f64,
}

/// A converged step, as an observer sees it.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// Number of the step, from 1; located events repeat the number of the step they lie in. 0 is
    /// the equilibrium under the loads that are there at the start, where there are any.
    pub number: usize,
    /// Load parameter.
    pub t: f64,
    /// Step in the load parameter, or along the path.
    pub step_size: f64,
    /// Coordinates in the charts of this step.
    pub q: &'a [f64],
    /// Linear solutions of this step, predictor included; of a located event those that locating it
    /// took, to which the one that ends a path adds those of the step it lies in.
    pub iterations: usize,
    /// History of the iterations; the last entry is the converged state.
    pub residuals: &'a [Iteration],
    /// Charts changed at the beginning of the step.
    pub chart_changes: usize,
    /// Index of the event located here, if it is one.
    pub event: Option<usize>,
    /// In how many directions the equilibrium is unstable: negative eigenvalues of the tangent at
    /// this very state, less one for each equation that has a multiplier. `None` where the tangent
    /// is not symmetric or is singular, as at a turning point, or where the solver does not know.
    pub unstable: Option<usize>,
}
