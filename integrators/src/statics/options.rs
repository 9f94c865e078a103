//! Options of load stepping, of path following and of Newton's method.

use super::StaticsError;

/// Load range and step sizes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StaticOptions {
    /// Load parameter at the start.
    pub from: f64,
    /// Load parameter at the end.
    pub to: f64,
    /// First step; it takes the sign of `to − from`.
    pub first_step: f64,
    /// A failed step is halved down to this size; then the analysis fails.
    pub min_step: f64,
    /// Largest step. Equal to `first_step` it gives equal steps (unless one fails).
    pub max_step: f64,
    /// Newton's method.
    pub newton: StaticNewtonOptions,
}

impl Default for StaticOptions {
    fn default() -> Self {
        Self {
            from: 0.0,
            to: 1.0,
            first_step: 0.1,
            min_step: 1e-6,
            max_step: 0.25,
            newton: StaticNewtonOptions::default(),
        }
    }
}

impl StaticOptions {
    /// `count` equal steps from 0 to 1, halved only if one of them fails.
    pub fn equal_steps(count: usize) -> Self {
        let step = 1.0 / count.max(1) as f64;
        Self {
            first_step: step,
            max_step: step,
            ..Self::default()
        }
    }
}

/// An event to locate and report on the path.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// The load has a maximum or minimum.
    TurningPoint,
    /// Another path crosses: one direction more or less is unstable, or several are, at a symmetric tangent.
    Bifurcation,
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

impl Event {
    /// Whether a system of n unknowns can have it.
    pub(super) fn can_occur(self, n: usize) -> bool {
        match self {
            Self::Coordinate { unknown, value } => unknown < n && value.is_finite(),
            Self::Load(value) => value.is_finite(),
            Self::TurningPoint | Self::Bifurcation => true,
        }
    }
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
    /// Whether the path goes on along the one that crosses it at the first [`Event::Bifurcation`] among the events:
    /// towards growing loads, or where the largest component of its shape is positive, in sizes of the coordinates; of
    /// equal ones the first.
    pub switch_branch: bool,
    /// Direction of the load at the start: true for growing.
    pub forward: bool,
    /// Newton's method.
    pub newton: StaticNewtonOptions,
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
            switch_branch: false,
            forward: true,
            newton: StaticNewtonOptions::default(),
        }
    }
}

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
}

/// The first invalid tolerance of Newton's method, with its name.
pub(crate) fn refused(relative: f64, absolute: f64) -> Option<(&'static str, f64)> {
    if !(relative > 0.0 && relative <= StaticNewtonOptions::LOOSEST) {
        return Some(("newton.relative", relative));
    }
    let usable = absolute >= 0.0 && absolute.is_finite();
    (!usable).then_some(("newton.absolute", absolute))
}

/// Rejects options that are not finite, and all but the ends of the load range unless positive.
pub(super) fn check(
    numbers: &[(&'static str, f64)],
    newton: &StaticNewtonOptions,
) -> Result<(), StaticsError> {
    let unusable = |&&(name, value): &&(&str, f64)| {
        !value.is_finite() || (value <= 0.0 && !["from", "to"].contains(&name))
    };
    let found = (numbers.iter().find(unusable).copied())
        .or_else(|| refused(newton.relative, newton.absolute));
    match found {
        Some((name, value)) => Err(StaticsError::Option { name, value }),
        None => Ok(()),
    }
}
