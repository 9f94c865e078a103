//! A force on one scalar coordinate.

use crate::element::{Abilities, Element, ElementEnergies, Motion, Properties, Response};
use crate::time::TimeFunction;
use pullback_manifold::domain::DomainError;

/// A force or moment conjugate to one scalar coordinate (a joint angle or a slide), given as a
/// function of time, such as the torque of an actuator; dim 1.
///
/// Residual F(t), energy −F x.
#[derive(Debug)]
pub struct CoordinateForce {
    force: Box<dyn TimeFunction>,
}

impl CoordinateForce {
    /// The force as a function of time.
    pub fn new(force: impl Into<Box<dyn TimeFunction>>) -> Self {
        Self {
            force: force.into(),
        }
    }
}

impl Element for CoordinateForce {
    fn dim(&self) -> usize {
        1
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let [force, rate, _] = self.force.at(at.t, at.inputs);
        out.r[0] += force;
        if let Some(r_t) = out.r_t.as_deref_mut() {
            r_t[0] += rate;
        }
        Ok(())
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities::of_energies(self)
    }

    fn kinks(&self) -> Vec<f64> {
        self.force.kinks()
    }

    fn properties(&self) -> Properties {
        Properties {
            dead: true,
            time_independent: self.force.constant().is_some(),
            ..Properties::LOAD
        }
    }
}

impl ElementEnergies for CoordinateForce {
    fn energy(&self, at: &Motion<'_>) -> f64 {
        -self.force.at(at.t, at.inputs)[0] * at.x[0]
    }
}
