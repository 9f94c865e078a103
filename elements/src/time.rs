//! Functions of time (or of the load parameter) for loads and prescribed motion.

use pullback_manifold::quotients::Quotients;
use std::f64::consts::TAU;
use std::fmt::Debug;

/// A function of time, and of the inputs of its model, with two derivatives by time.
pub trait TimeFunction: Send + Sync + Debug {
    /// Value, first and second derivative at `t` and the present values of all inputs ([`Input`]),
    /// which are constant during a step.
    ///
    /// At a kink, the derivatives from the right.
    fn at(&self, t: f64, inputs: &[f64]) -> [f64; 3];

    /// Its value, if it is known to be constant.
    fn constant(&self) -> Option<f64> {
        None
    }

    /// Times at which a derivative jumps, where time steps end.
    fn kinks(&self) -> Vec<f64> {
        Vec::new()
    }
}

impl<F: TimeFunction + 'static> From<F> for Box<dyn TimeFunction> {
    fn from(function: F) -> Self {
        Box::new(function)
    }
}

/// Error of a time function.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "each message says what its variant is")]
#[non_exhaustive]
pub enum TimeFunctionError {
    #[error("a time function needs finite numbers, got {0}")]
    NotFinite(f64),
    #[error("times must increase strictly, but {previous} is followed by {next}")]
    NotIncreasing { previous: f64, next: f64 },
    #[error("a table needs at least one point")]
    Empty,
}

/// f(t) = value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constant(pub f64);

impl TimeFunction for Constant {
    fn at(&self, _: f64, _: &[f64]) -> [f64; 3] {
        [self.0, 0.0, 0.0]
    }

    fn constant(&self) -> Option<f64> {
        Some(self.0)
    }
}

/// A value that a program sets during a run, such as the torque of a controller: its index among the
/// inputs of a model.
///
/// Created by [`ModelBuilder::input`](crate::model::ModelBuilder::input). The values are part of the state:
/// [`Context::set_input`](crate::model::Context::set_input). If one changes between two steps, a run finds new
/// accelerations, and where prescribed velocities jump new velocities, as at a kink.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Input(pub(crate) usize);

impl From<Input> for usize {
    fn from(input: Input) -> Self {
        input.0
    }
}

impl TimeFunction for Input {
    fn at(&self, _: f64, inputs: &[f64]) -> [f64; 3] {
        [inputs.get(self.0).copied().unwrap_or(f64::NAN), 0.0, 0.0]
    }
}

/// f(t) = Ω t, where Ω is an input: a rotation with a constant speed. Another Ω in a motion is another angle at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SteadyRotation(pub Input);

impl TimeFunction for SteadyRotation {
    fn at(&self, t: f64, inputs: &[f64]) -> [f64; 3] {
        let [speed, ..] = self.0.at(t, inputs);
        [speed * t, speed, 0.0]
    }
}

/// f(t) = slope · t for all t, like a load parameter in statics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proportional(pub f64);

impl TimeFunction for Proportional {
    fn at(&self, t: f64, _: &[f64]) -> [f64; 3] {
        [self.0 * t, self.0, 0.0]
    }

    fn constant(&self) -> Option<f64> {
        (self.0 == 0.0).then_some(0.0)
    }
}

/// f(t) = offset + amplitude · sin(omega t + phase).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sine {
    /// Amplitude.
    pub amplitude: f64,
    /// Angular frequency in rad per unit of time.
    pub omega: f64,
    /// Phase in radians.
    pub phase: f64,
    /// Mean value.
    pub offset: f64,
}

impl TimeFunction for Sine {
    fn at(&self, t: f64, _: &[f64]) -> [f64; 3] {
        let (s, c) = (self.omega * t + self.phase).sin_cos();
        let a = self.amplitude;
        [
            self.offset + a * s,
            a * self.omega * c,
            -a * self.omega * self.omega * s,
        ]
    }
}

/// Piecewise linear between points, constant before the first and after the last.
///
/// Ramps and triangles are tables of two and three points.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    points: Vec<[f64; 2]>,
}

impl Table {
    /// A table of (time, value) pairs with increasing times.
    ///
    /// # Errors
    /// [`TimeFunctionError`] for no points, numbers that are not finite, or times that do not
    /// increase.
    pub fn new(points: Vec<[f64; 2]>) -> Result<Self, TimeFunctionError> {
        if points.is_empty() {
            return Err(TimeFunctionError::Empty);
        }
        if let Some(&x) = points.iter().flatten().find(|x| !x.is_finite()) {
            return Err(TimeFunctionError::NotFinite(x));
        }
        if let Some(w) = points.windows(2).find(|w| w[1][0] <= w[0][0]) {
            return Err(TimeFunctionError::NotIncreasing {
                previous: w[0][0],
                next: w[1][0],
            });
        }
        Ok(Self { points })
    }

    /// From 0 at `start` to `value` at `end`, constant outside.
    ///
    /// # Errors
    /// As [`Table::new`].
    pub fn ramp(start: f64, end: f64, value: f64) -> Result<Self, TimeFunctionError> {
        Self::new(vec![[start, 0.0], [end, value]])
    }

    /// From 0 at `start` up to `value` at `peak` and back to 0 at `end`.
    ///
    /// # Errors
    /// As [`Table::new`].
    pub fn triangle(
        start: f64,
        peak: f64,
        end: f64,
        value: f64,
    ) -> Result<Self, TimeFunctionError> {
        Self::new(vec![[start, 0.0], [peak, value], [end, 0.0]])
    }
}

impl TimeFunction for Table {
    fn at(&self, t: f64, _: &[f64]) -> [f64; 3] {
        let after = self.points.partition_point(|p| p[0] <= t);
        if after == 0 {
            return [self.points[0][1], 0.0, 0.0];
        }
        let [t0, f0] = self.points[after - 1];
        match self.points.get(after) {
            None => [f0, 0.0, 0.0],
            Some([t1, f1]) => {
                let slope = (f1 - f0) / (t1 - t0);
                [f0 + slope * (t - t0), slope, 0.0]
            }
        }
    }

    fn constant(&self) -> Option<f64> {
        let first = self.points[0][1];
        self.points.iter().all(|p| p[1] == first).then_some(first)
    }

    fn kinks(&self) -> Vec<f64> {
        self.points.iter().map(|p| p[0]).collect()
    }
}

/// `value` from `start` until `end`, zero otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    start: f64,
    end: f64,
    value: f64,
}

impl Pulse {
    /// A rectangular pulse.
    ///
    /// # Errors
    /// [`TimeFunctionError`] for numbers that are not finite, or an end that is not after the
    /// start.
    pub fn new(start: f64, end: f64, value: f64) -> Result<Self, TimeFunctionError> {
        Table::ramp(start, end, value)?;
        Ok(Self { start, end, value })
    }
}

impl TimeFunction for Pulse {
    fn at(&self, t: f64, _: &[f64]) -> [f64; 3] {
        let on = self.start <= t && t < self.end;
        [if on { self.value } else { 0.0 }, 0.0, 0.0]
    }

    fn kinks(&self) -> Vec<f64> {
        vec![self.start, self.end]
    }
}

/// A smooth spin-up from rest to a constant rate within a duration T:
/// f = (rate/T) (t²/2 + (T/2π)² (cos(2πt/T) − 1)), then rate·(t − T/2).
///
/// Rate and acceleration are continuous (Kane, Ryan & Banerjee 1987).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpinUp {
    rate: f64,
    duration: f64,
}

impl SpinUp {
    /// A spin-up to `rate` in `duration`.
    ///
    /// # Errors
    /// [`TimeFunctionError`] for numbers that are not finite, or a duration that is not positive.
    pub fn new(rate: f64, duration: f64) -> Result<Self, TimeFunctionError> {
        Table::ramp(0.0, duration, rate)?;
        Ok(Self { rate, duration })
    }
}

impl TimeFunction for SpinUp {
    fn at(&self, t: f64, _: &[f64]) -> [f64; 3] {
        let (rate, T) = (self.rate, self.duration);
        if t <= 0.0 {
            return [0.0; 3];
        }
        if t >= T {
            return [rate * (t - 0.5 * T), rate, 0.0];
        }
        // ½ t² + (cos x − 1)/k², t − sin x/k and 1 − cos x with x = k t, without differences of nearly equal numbers.
        let x = TAU / T * t;
        let (half, all) = (Quotients::new(0.5 * x), Quotients::new(x));
        [
            rate / T * 0.5 * (0.5 * x * t).powi(2) * half.c5 * (1.0 + half.sinc),
            rate / T * x * x * t * all.c5,
            rate / T * x * x * all.one_minus_cos,
        ]
    }

    fn kinks(&self) -> Vec<f64> {
        vec![self.duration]
    }
}
