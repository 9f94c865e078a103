//! Functions of the load parameter, or of time.

use pullback_elements::time::{self as function, TimeFunction, TimeFunctionError};
use pullback_elements::time::{Constant, Proportional, Table};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A function f(t) of the load parameter in statics, of time in dynamics: a factor for loads, the
/// value itself for prescribed coordinates.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
#[non_exhaustive]
pub enum Time {
    /// f(t) = value.
    Constant(f64),
    /// f(t) = slope · t.
    Proportional(f64),
    /// From 0 to a value and constant afterwards.
    Ramp(Ramp),
    /// From 0 up to a value and back to 0.
    Triangle(Triangle),
    /// A value from one time until another, 0 before and after.
    Pulse(Pulse),
    /// A smooth spin-up to a constant rate.
    #[serde(rename = "spin_up")]
    SpinUp(SpinUp),
    /// Straight lines between points [t, f], constant before the first and after the last.
    Table(Vec<[f64; 2]>),
    /// f(t) = offset + amplitude · sin(omega t + phase).
    Sine(Sine),
    /// The value of an input, by its name; it is constant unless changed from outside.
    Input(String),
}

/// From 0 at `start` to `value` at `end`, constant outside.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ramp {
    /// Start of the rise.
    #[serde(default)]
    pub start: f64,
    /// End of the rise.
    pub end: f64,
    /// The value reached.
    #[serde(default = "one")]
    pub value: f64,
}

/// From 0 at `start` up to `value` at `peak` and back to 0 at `end`.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Triangle {
    /// Start of the rise.
    #[serde(default)]
    pub start: f64,
    /// End of the rise.
    pub peak: f64,
    /// End of the fall.
    pub end: f64,
    /// The value at the peak.
    #[serde(default = "one")]
    pub value: f64,
}

/// `value` from `start` until `end`, 0 before and after.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pulse {
    /// Start of the pulse.
    #[serde(default)]
    pub start: f64,
    /// End of the pulse.
    pub end: f64,
    /// Its value.
    #[serde(default = "one")]
    pub value: f64,
}

/// From rest to `rate` within `duration`, without a jump in the acceleration:
/// f = rate/T (t²/2 + (T/2π)² (cos(2πt/T) − 1)), then rate (t − T/2).
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpinUp {
    /// Rate of change at the end.
    pub rate: f64,
    /// Time T that it takes.
    pub duration: f64,
}

/// A sine.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sine {
    /// Amplitude.
    #[serde(default = "one")]
    pub amplitude: f64,
    /// Angular frequency in radians per unit of t.
    pub omega: f64,
    /// Phase in radians.
    #[serde(default)]
    pub phase: f64,
    /// Mean value.
    #[serde(default)]
    pub offset: f64,
}

impl Time {
    /// The function of the model, with inputs as constants.
    ///
    /// # Errors
    /// [`TimeFunctionError`] for numbers that are not finite and times that do not increase.
    pub fn function(
        &self,
        inputs: &BTreeMap<String, f64>,
    ) -> Result<Box<dyn TimeFunction>, TimeFunctionError> {
        Ok(match self {
            Self::Constant(value) => Box::new(Constant(*value)),
            Self::Proportional(slope) => Box::new(Proportional(*slope)),
            Self::Ramp(r) => Box::new(Table::ramp(r.start, r.end, r.value)?),
            Self::Triangle(h) => Box::new(Table::triangle(h.start, h.peak, h.end, h.value)?),
            Self::Pulse(p) => Box::new(function::Pulse::new(p.start, p.end, p.value)?),
            Self::SpinUp(r) => Box::new(function::SpinUp::new(r.rate, r.duration)?),
            Self::Table(points) => Box::new(Table::new(points.clone())?),
            Self::Sine(s) => Box::new(function::Sine {
                amplitude: s.amplitude,
                omega: s.omega,
                phase: s.phase,
                offset: s.offset,
            }),
            Self::Input(name) => Box::new(Constant(inputs.get(name).copied().unwrap_or(0.0))),
        })
    }
}

fn one() -> f64 {
    1.0
}
