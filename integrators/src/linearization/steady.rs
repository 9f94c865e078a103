//! Steady motion: equilibrium relative to frames in prescribed motion.

use super::differences::{central, step};
use super::events;
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::{Evaluation, Point, Scales, System, SystemError};

/// A system at one instant of its prescribed motion, with all coordinates at rest: q̇ = q̈ = 0.
///
/// Where the coordinates are relative to a frame that rotates with a constant speed, an equilibrium of this
/// system is a steady rotation. Its load parameter is the value of an input, such as the speed: statics
/// finds the equilibria ([`equilibrium`](crate::statics::equilibrium)), and
/// [`linearize`](super::linearize) at velocities and accelerations of zero their matrices K, C and M.
pub struct SteadyMotion<'a> {
    system: &'a mut dyn System,
    t: f64,
    input: usize,
    zeros: Vec<f64>,
}

impl<'a> SteadyMotion<'a> {
    /// The system at time `t`, with the input of this number as its load parameter.
    ///
    /// # Panics
    /// At the first evaluation if the system has no such input.
    pub fn new(system: &'a mut dyn System, t: f64, input: impl Into<usize>) -> Self {
        Self {
            zeros: vec![0.0; system.pattern().dim()],
            system,
            t,
            input: input.into(),
        }
    }
}

impl System for SteadyMotion<'_> {
    fn pattern(&self) -> &BlockPattern {
        self.system.pattern()
    }

    fn evaluate(&mut self, at: Point<'_>, mut out: Evaluation<'_>) -> Result<(), SystemError> {
        let still = Point {
            t: self.t,
            q: at.q,
            v: &self.zeros,
            a: &self.zeros,
        };
        if let Some(previous) = &mut out.previous {
            previous.t = self.t;
        }
        if let Some(r_t) = out.r_t.take() {
            // Exact for speeds and loads.
            let rate = central(step(at.t, 1.0), |du| {
                events(&mut *self.system).inputs()[self.input] = at.t + du;
                let mut r = vec![0.0; r_t.len()];
                self.system.evaluate(still, Evaluation::residual(&mut r))?;
                Ok(r)
            })?;
            r_t.iter_mut().zip(rate).for_each(|(r_t, x)| *r_t = x.value);
        }
        events(&mut *self.system).inputs()[self.input] = at.t;
        self.system.evaluate(still, out)
    }

    fn scales(&self) -> Scales {
        self.system.scales()
    }

    fn name(&self, i: usize) -> String {
        self.system.name(i)
    }
}
