//! Schemes that conserve energy and momenta by projection.

use super::{Family, Scheme};

/// Newmark's scheme, or generalised-α, with its steps projected onto energy and momenta.
pub(super) const PROJECTED_NEWMARK: Family = Family {
    word: "projected-newmark",
    long: "projected-newmark",
    usage: "projected-newmark (the trapezoidal rule), or projected-newmark:RHO (generalised-alpha with \
            the spectral radius in [0, 1]); energy and momenta are restored after every step",
    stability: None,
    make: |numbers| match *numbers {
        [] => Some(Ok(Scheme::trapezoidal().keeping(None))),
        [rho] => Some(Scheme::chung_hulbert(rho).map(|base| base.keeping(Some(rho)))),
        _ => None,
    },
};

impl Scheme {
    /// Projects the steps of a scheme onto the energy and the momenta of the motion (Hairer, Lubich
    /// & Wanner, *Geometric Numerical Integration*, IV.4; the idea of constraining a scheme to its
    /// integrals is that of Hughes, Caughey & Liu 1978, with momenta and numerical damping Kuhl &
    /// Ramm 1996).
    ///
    /// Kinetic and stored energy with the potential of steady loads are conserved exactly if nothing
    /// else does work, within the possible work of dampers and other loads
    /// ([`Invariants::unsure`](crate::dynamics::Invariants::unsure)), and not at all while a motion is
    /// prescribed, when the energy is only known to the accuracy of the step. So are the momenta along
    /// the symmetries of the system
    /// ([`Energetics::symmetries`](pullback_manifold::system::Energetics::symmetries)): those of a free model,
    /// or of one that is pinned at a point or attached to an axis. The projection is orthogonal in the
    /// kinetic energy, of the order of the local error, and needs no factorisation.
    pub(super) fn keeping(mut self, argument: Option<f64>) -> Self {
        self.properties.symmetric = false;
        Self {
            name: "projected-newmark",
            word: "projected-newmark",
            arguments: [argument, None],
            projected: true,
            ..self
        }
    }

    /// Whether steps are projected onto the energy and the momenta of the motion.
    pub fn keeps_energy(&self) -> bool {
        self.projected
    }
}
