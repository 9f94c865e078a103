//! Integration in time of any [`System`](pullback_manifold::system::System): Newmark, HHT, WBZ and
//! generalised-α, composite, Runge-Kutta and explicit schemes by one step routine.
//!
//! A step reads as verbs: predict, evaluate, solve, correct, accept. All variables live in one
//! vector space per chart, so the schemes apply to q directly; after an accepted step the system
//! may change its charts and transforms q, q̇, q̈ and the algorithmic acceleration.

#![allow(non_snake_case)]

mod coupled_stages;
mod error;
mod events;
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
mod simulation;
mod stages;
mod step;
mod stops;

pub use error::DynamicsError;
pub use initial::start;
pub use invariants::Invariants;
pub use options::{Adaptivity, DynamicOptions};
pub use progress::{EnergyBalance, Progress, StepReport, Summary};
pub use scheme::Scheme;
pub use simulation::{Simulation, Snapshot, integrate, integrate_with};
pub(crate) use step::Stepper;
pub use step::{Predictor, Tangent};

/// State of motion between steps.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Time.
    pub t: f64,
    /// Coordinates in their charts.
    pub q: Vec<f64>,
    /// Velocities q̇.
    pub v: Vec<f64>,
    /// Accelerations q̈ from the equations of motion.
    pub a: Vec<f64>,
    /// Algorithmic accelerations; equal to q̈ for Newmark's scheme.
    pub algorithmic: Vec<f64>,
}

/// Options of Newton's method within a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonOptions {
    /// Residual relative to applied and reaction forces (moments) at convergence; without any
    /// forces, only rounding errors are allowed.
    pub relative: f64,
    /// Absolute tolerance of the same test, in units of force (moment); 0 allows only rounding errors.
    pub absolute: f64,
    /// Largest number of iterations per step.
    pub max_iterations: usize,
    /// When the tangent is factorised.
    pub tangent: Tangent,
    /// The start of the iteration.
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
