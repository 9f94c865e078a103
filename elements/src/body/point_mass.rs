//! A point mass at a node.

use crate::element::{Abilities, Element, ElementEnergies, Motion, Properties, Response};
use crate::inertia::InertiaError;
use crate::load::{LoadKind, NodalLoad};
use crate::time::TimeFunction;
use pullback_manifold::domain::DomainError;

/// Mass m at the point of a frame node; dim 6.
///
/// It has no rotational inertia: its rows of M for Ψ are zero, so the node's rotation must be held
/// or resisted by something else (a beam, a joint, a spring). Inertia force −m d̈.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMass {
    m: f64,
}

impl PointMass {
    /// A mass (unit M).
    ///
    /// # Errors
    /// [`InertiaError`] unless the mass is positive and finite.
    pub fn new(mass: f64) -> Result<Self, InertiaError> {
        if !mass.is_finite() {
            return Err(InertiaError::NotFinite {
                quantity: "the mass",
                value: mass,
            });
        }
        if mass <= 0.0 {
            return Err(InertiaError::Mass {
                required: "positive",
                mass,
            });
        }
        Ok(Self { m: mass })
    }

    /// Its weight in a field g (acceleration, global components) times `amplitude`: a load on the
    /// same node.
    #[must_use]
    pub fn weight(&self, g: [f64; 3], amplitude: impl Into<Box<dyn TimeFunction>>) -> NodalLoad {
        NodalLoad::new(LoadKind::DeadForce, g.map(|g| g * self.m), amplitude)
    }
}

impl Element for PointMass {
    fn dim(&self) -> usize {
        6
    }

    fn properties(&self) -> Properties {
        Properties {
            sees_rotations: false,
            ..Properties::INTERNAL
        }
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities::of_energies(self)
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        for (r, a) in out.r.iter_mut().zip(at.a).take(3) {
            *r -= self.m * a;
        }
        if let Some(M) = out.M.as_deref_mut() {
            for k in 0..3 {
                M[7 * k] += self.m;
            }
        }
        Ok(())
    }
}

impl ElementEnergies for PointMass {
    fn kinetic_energy(&self, at: &Motion<'_>) -> Option<f64> {
        let squares = at.v.iter().take(3).map(|v| v * v);
        Some(0.5 * self.m * squares.sum::<f64>())
    }
}
