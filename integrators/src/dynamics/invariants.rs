//! Invariants of a motion.

use pullback_manifold::system::{Energies, Symmetry};

/// Invariants of a motion: the target of a scheme that restores them.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Invariants {
    /// Kinetic and stored energy and potential of steady loads, with the work of everything else by
    /// the trapezoidal rule.
    pub energy: f64,
    /// Tolerance of the energy: the sum of the magnitudes of that work.
    ///
    /// The power between the ends of a step is unknown; that of a damper at the ends says little
    /// about a step that does not resolve its relaxation. The trapezoidal rule takes half the sum
    /// of the powers, so a damper alone has dissipated between nothing and twice as much.
    pub unsure: f64,
    /// Present power of everything else.
    pub power: f64,
    /// The same with the magnitudes of gains and losses.
    pub gross_power: f64,
    /// The momenta that change at constant rates.
    pub momenta: Vec<Momentum>,
}

/// The momentum along a symmetry.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Momentum {
    /// The symmetry, with the rate of the momentum.
    pub symmetry: Symmetry,
    /// The momentum.
    pub value: f64,
}

impl Invariants {
    /// The energy and powers of a state.
    pub(super) fn of(now: &Energies) -> Self {
        let mut invariants = Self {
            energy: now.total(),
            ..Self::default()
        };
        invariants.set_power(now);
        invariants
    }

    /// Adds the work and the impulses of a step of size h, with the powers at its end.
    pub(super) fn add_step(&mut self, now: &Energies, h: f64) {
        self.energy += 0.5 * h * (self.power + now.power());
        self.unsure += 0.5 * h * (self.gross_power + gross_power(now));
        self.momenta
            .iter_mut()
            .for_each(|m| m.value += h * m.symmetry.force);
        self.set_power(now);
    }

    /// Takes over the powers of a state.
    pub(super) fn set_power(&mut self, now: &Energies) {
        (self.power, self.gross_power) = (now.power(), gross_power(now));
    }

    /// Difference of an energy to the nearest one within the tolerance.
    pub(super) fn energy_gap(&self, energy: f64) -> f64 {
        let off = self.energy - energy;
        off - off.min(self.unsure).max(-self.unsure)
    }
}

fn gross_power(now: &Energies) -> f64 {
    (now.supplied - now.drawn).abs() + now.dissipated.abs()
}
