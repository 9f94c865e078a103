//! What is asked of a path, and what it did.

use super::{NewtonOptions, Summary};

/// Something on the path to be located and reported.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// The load has a maximum or minimum.
    TurningPoint,
    /// The load parameter passes a value.
    Load(f64),
    /// A coordinate passes a value.
    Coordinate {
        /// Which unknown.
        unknown: usize,
        /// Its value.
        value: f64,
    },
}

/// Options of [`trace_path`](super::trace_path).
#[derive(Clone, Debug, PartialEq)]
pub struct ArcLengthOptions {
    /// Load parameter at the start.
    pub from: f64,
    /// First step along the path. With the default scale, 0.05 changes the load by at most 0.05.
    pub first_step: f64,
    /// Largest step along the path.
    pub max_step: f64,
    /// A failed step is halved until it is smaller than this.
    pub min_step: f64,
    /// Steps at most.
    pub max_steps: usize,
    /// Change of the load parameter that counts as much as a change of the coordinates by their
    /// scales.
    pub load_scale: f64,
    /// Iterations a step should take; fewer make the next one larger, more make it smaller.
    pub target_iterations: usize,
    /// Events to be located and reported, each with its index; `true` ends the path there.
    pub events: Vec<(Event, bool)>,
    /// Sense in which the load changes at the start: true for growing.
    pub forward: bool,
    /// Newton's method.
    pub newton: NewtonOptions,
}

impl Default for ArcLengthOptions {
    fn default() -> Self {
        Self {
            from: 0.0,
            first_step: 0.05,
            max_step: 0.1,
            min_step: 1e-7,
            max_steps: 500,
            load_scale: 1.0,
            target_iterations: 5,
            events: vec![(Event::Load(1.0), true)],
            forward: true,
            newton: NewtonOptions::default(),
        }
    }
}

/// What a path did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathSummary {
    /// Counts as in load stepping; `finished` says that an ending event was reached.
    pub summary: Summary,
    /// Events in the order in which they were met: index and load parameter.
    pub events: Vec<(usize, f64)>,
}
