//! Schemes that keep energy and momenta by projection.

use super::{Family, Scheme, SchemeProperties};

/// The energy-momentum projection of the generalised-α family.
pub(super) const ENERGY_MOMENTUM: Family = Family {
    word: "em",
    long: "energy-momentum",
    usage: "em (the trapezoidal rule), or em:RHO (generalised-alpha with the spectral radius in \
            [0, 1]); energy and momenta are restored after every step",
    stability: None,
    make: |numbers| match *numbers {
        [] => Some(Ok(Scheme::trapezoidal().keeping(None))),
        [rho] => Some(Scheme::chung_hulbert(rho).map(|base| base.keeping(Some(rho)))),
        _ => None,
    },
};

impl Scheme {
    /// The scheme with its steps projected back to the energy and the momenta that the motion has
    /// (Hairer, Lubich & Wanner, *Geometric Numerical Integration*, IV.4; the idea of constraining a
    /// scheme to its integrals is that of Hughes, Caughey & Liu 1978, with momenta and numerical
    /// damping Kuhl & Ramm 1996).
    ///
    /// What is kept: kinetic and stored energy with the potential of steady loads, exactly where nothing
    /// else works; within what dampers and other loads may have done
    /// ([`Invariants::unsure`](crate::dynamics::Invariants::unsure)) where they do; not at all while something is
    /// driven, when the energy is known no better than by the step. And the momenta along the symmetries of the system
    /// ([`System::symmetries`](pullback_manifold::system::System::symmetries)), those of a free model,
    /// of one that is pinned at a point or attached to an axis. The projection is orthogonal in the
    /// kinetic energy, of the order of the local error, and needs no factorisation.
    pub(super) fn keeping(self, argument: Option<f64>) -> Self {
        let properties = SchemeProperties {
            symmetric: false,
            ..self.properties
        };
        Self {
            name: "energy-momentum",
            word: "em",
            arguments: [argument, None],
            properties,
            keeps: true,
            ..self
        }
    }

    /// Whether its steps are projected back to the energy and the momenta of the motion.
    pub fn keeps_energy(&self) -> bool {
        self.keeps
    }
}
