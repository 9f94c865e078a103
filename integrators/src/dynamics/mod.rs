//! Integration in time of any [`System`](pullback_manifold::system::System): Newmark, HHT, WBZ and
//! generalised-α, composite, Runge-Kutta and explicit schemes by one step routine.
//!
//! A step reads as verbs: predict, evaluate, solve, correct, accept. All variables live in one
//! vector space per chart, so the schemes apply to q directly; after an accepted step the system
//! may change its charts, which takes q, q̇, q̈ and the algorithmic acceleration along.

#![allow(non_snake_case)]

mod coupled_stages;
mod error;
mod frequency;
mod initial;
mod invariants;
mod jumps;
mod options;
mod progress;
mod projection;
mod run;
pub mod scheme;
mod segment_changes;
mod stages;
mod step;
mod stops;

pub use error::DynamicsError;
pub use initial::start;
pub use invariants::Invariants;
pub use options::{Adaptivity, DynamicOptions};
pub use progress::{EnergyBalance, Progress, StepReport, Summary};
pub use run::{integrate, integrate_with};
pub use scheme::Scheme;
pub(crate) use step::Stepper;
pub use step::{Predictor, Tangent};

/// A state of motion: what a scheme carries from step to step.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Time.
    pub t: f64,
    /// Coordinates in their charts.
    pub q: Vec<f64>,
    /// Velocities q̇.
    pub v: Vec<f64>,
    /// Accelerations q̈, those of the equations of motion.
    pub a: Vec<f64>,
    /// Algorithmic accelerations; equal to q̈ for Newmark's scheme.
    pub algorithmic: Vec<f64>,
}

/// Newton's method inside a step: when to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonOptions {
    /// Residual relative to applied and reaction forces (moments) at which a step has converged;
    /// where there are none, only rounding errors may be left.
    pub relative: f64,
    /// Absolute floor of the same test, in units of force (moment); 0 leaves only rounding errors
    /// unmended, whatever the size of the model.
    pub absolute: f64,
    /// Iterations per step at most.
    pub max_iterations: usize,
    /// How often the tangent is factorised.
    pub tangent: Tangent,
    /// Where the iteration begins.
    pub predictor: Predictor,
}

impl Default for NewtonOptions {
    fn default() -> Self {
        Self {
            relative: 1e-9,
            absolute: 0.0,
            max_iterations: 15,
            tangent: Tangent::default(),
            predictor: Predictor::default(),
        }
    }
}
