//! Options and results of path following.

use super::{NewtonOptions, Summary};

/// An event to locate and report on the path.
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
    /// Largest number of steps.
    pub max_steps: usize,
    /// Change of the load parameter that counts as much as a change of the coordinates by their scales.
    pub load_scale: f64,
    /// Desired number of iterations of a step; fewer make the next one larger, more make it smaller.
    pub target_iterations: usize,
    /// Events to locate and report, each with whether it ends the path.
    pub events: Vec<(Event, bool)>,
    /// Direction of the load at the start: true for growing.
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

/// Results of path following.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathSummary {
    /// Counters as in load stepping; `finished` says that an ending event was reached.
    pub summary: Summary,
    /// Events in order: index and load parameter.
    pub events: Vec<(usize, f64)>,
}
