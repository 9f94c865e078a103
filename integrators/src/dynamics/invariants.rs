//! What a motion keeps, as far as that is known.

use pullback_manifold::system::{Energies, RigidRates};

/// What a motion keeps: the aim of a scheme that restores it.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Invariants {
    /// Kinetic and stored energy and potential of steady loads, with the work of everything else by
    /// the trapezoidal rule.
    pub energy: f64,
    /// By how much the energy may be another: that work, whatever its sign.
    ///
    /// Between the ends of a step the power is not known; that of a damper there says little of what
    /// it takes in a step that does not resolve its relaxation. The rule is half the sum of the
    /// powers, so a damper alone has taken between nothing and twice as much.
    #[cfg_attr(feature = "serde", serde(default))]
    pub unsure: f64,
    /// Power of everything else now.
    pub power: f64,
    /// The same, gains and losses both taken as positive.
    #[cfg_attr(feature = "serde", serde(default))]
    pub gross_power: f64,
    /// Symmetries: velocity of the origin, angular velocity.
    pub motions: Vec<RigidRates>,
    /// Momenta along them.
    pub momenta: Vec<f64>,
    /// Rates of these momenta: constant forces.
    #[cfg_attr(feature = "serde", serde(default))]
    pub forces: Vec<f64>,
}

impl Invariants {
    /// The energy of a state, and what works on it.
    pub(super) fn of(now: &Energies) -> Self {
        let mut invariants = Self {
            energy: now.total(),
            ..Self::default()
        };
        invariants.set_power(now);
        invariants
    }

    /// Books the work and the impulses of a step of size h, with the powers at its end.
    pub(super) fn add_step(&mut self, now: &Energies, h: f64) {
        self.energy += 0.5 * h * (self.power + now.power());
        self.unsure += 0.5 * h * (self.gross_power + gross_power(now));
        for (momentum, force) in self.momenta.iter_mut().zip(&self.forces) {
            *momentum += h * force;
        }
        self.set_power(now);
    }

    /// Notes the powers of a state.
    pub(super) fn set_power(&mut self, now: &Energies) {
        (self.power, self.gross_power) = (now.power(), gross_power(now));
    }

    /// What an energy lacks of the nearest one that is possible.
    pub(super) fn energy_gap(&self, energy: f64) -> f64 {
        let off = self.energy - energy;
        off - off.min(self.unsure).max(-self.unsure)
    }
}

fn gross_power(now: &Energies) -> f64 {
    (now.supplied - now.drawn).abs() + now.dissipated.abs()
}
