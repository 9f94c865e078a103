//! Integration in time of any [`System`]: Newmark, HHT, WBZ and
//! generalised-α, composite, Runge-Kutta and explicit schemes by one step routine.
//!
//! A step predicts, evaluates the system, solves, corrects and accepts. In one chart all variables
//! are elements of a vector space, so the schemes apply to q directly; after an accepted step the
//! system may change its charts and transforms q, q̇, q̈ and the algorithmic acceleration.

mod accept;
mod attempt;
mod coupled_stages;
mod error;
mod events;
mod frequency;
mod initial;
mod invariants;
mod jumps;
mod mass;
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
pub use invariants::{Invariants, Momentum};
pub use options::{Adaptivity, DynamicOptions, NewtonOptions, Predictor, TangentUpdate};
pub use progress::{EnergyBalance, Progress, StepReport, Summary};
pub use scheme::Scheme;
pub use simulation::{Simulation, Snapshot, integrate};
pub(crate) use step::Stepper;

use crate::abilities::charts;
use pullback_manifold::system::{ChartChanges, Point, System};

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
    /// Accelerations q̈ from the equations of motion at q and q̇; a run computes them if they are empty.
    pub a: Vec<f64>,
    /// Algorithmic accelerations; equal to q̈ for Newmark's scheme.
    pub algorithmic: Vec<f64>,
    /// Accelerations of the step itself, which the filter of the generalised-α method goes on with: with multipliers they satisfy
    /// h = 0 at its end, and differ from q̈.
    pub filtered: Vec<f64>,
}

impl State {
    /// The state as a point at which a system is evaluated.
    pub fn point(&self) -> Point<'_> {
        let Self { t, q, v, a, .. } = self;
        Point { t: *t, q, v, a }
    }

    /// Changes charts where needed.
    pub fn change_charts(&mut self, system: &mut dyn System) -> ChartChanges {
        let Self { q, v, a, .. } = self;
        let vectors: &mut [&mut [f64]] = &mut [a, &mut self.algorithmic, &mut self.filtered];
        charts(system).change_charts(self.t, q, v, vectors)
    }
}
