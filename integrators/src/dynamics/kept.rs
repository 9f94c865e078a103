//! What a motion keeps, as far as that is known.

use pullback_manifold::system::{Energies, RigidRates};

/// What a motion keeps: the aim of a scheme that restores it.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Kept {
    /// Kinetic and stored energy and potential of steady loads.
    pub energy: f64,
    /// Power of everything else now.
    pub power: f64,
    /// The same, gains and losses both taken as positive.
    #[cfg_attr(feature = "serde", serde(default))]
    pub gross_power: f64,
    /// Symmetries: velocity of the origin, angular velocity.
    pub motions: Vec<RigidRates>,
    /// Momenta along them.
    pub momenta: Vec<f64>,
}

impl Kept {
    /// The energies that the work of a step of size h allows: what was there with the powers at both
    /// ends by the trapezoidal rule, give or take as much.
    ///
    /// Between the ends the power is not known: that of a damper at the ends of a step which does not
    /// resolve its relaxation says little of what it takes. A damper alone takes between
    /// nothing and twice the value of the rule.
    pub(super) fn range(&self, now: &Energies, h: f64) -> [f64; 2] {
        let work = 0.5 * h * (self.power + now.power());
        let unsure = 0.5 * h * (self.gross_power + gross_power(now));
        [
            self.energy + (work - unsure),
            self.energy + (work + unsure),
        ]
    }

    /// Takes the energy of the end of a step of size h as far as its work allows.
    pub(super) fn follow(&mut self, now: &Energies, h: f64) {
        self.energy = nearest(now.total(), self.range(now, h));
        self.note(now);
    }

    pub(super) fn note(&mut self, now: &Energies) {
        (self.power, self.gross_power) = (now.power(), gross_power(now));
    }
}

pub(super) fn gross_power(now: &Energies) -> f64 {
    (now.supplied - now.drawn).abs() + now.dissipated.abs()
}

pub(super) fn nearest(energy: f64, range: [f64; 2]) -> f64 {
    energy.max(range[0]).min(range[1])
}
