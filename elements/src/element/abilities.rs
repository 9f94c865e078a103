//! Abilities of an element beyond its evaluation.

use super::{CombinedTangents, Motion};
use crate::constraint::Enforced;
use nalgebra::{Matrix3, Vector3};
use pullback_manifold::domain::DomainError;

/// Optional abilities of an element; none by default.
///
/// A wrapper of another element writes out all fields, so that it does not compile without a new one.
#[derive(Clone, Copy, Default)]
pub struct Abilities<'a> {
    /// The combined tangent, if it can be formed faster than from its parts.
    pub combined: Option<&'a dyn Combined>,
    /// Its energies; zero without them.
    pub energies: Option<&'a dyn ElementEnergies>,
    /// The equations that it enforces on its coordinates.
    pub enforced: Option<&'a dyn Enforced>,
    /// Its cross-sections, for output.
    pub sections: Option<&'a dyn CrossSections>,
}

impl<'a> Abilities<'a> {
    /// Those of an element with energies alone.
    #[must_use]
    pub fn of_energies(energies: &'a dyn ElementEnergies) -> Self {
        Self {
            energies: Some(energies),
            ..Self::default()
        }
    }

    /// [`ElementEnergies::energy`]; zero without energies.
    pub fn energy(&self, at: &Motion<'_>) -> f64 {
        self.energies.map_or(0.0, |e| e.energy(at))
    }

    /// [`ElementEnergies::kinetic_energy`]; `None` without energies.
    pub fn kinetic_energy(&self, at: &Motion<'_>) -> Option<f64> {
        self.energies?.kinetic_energy(at)
    }

    /// [`ElementEnergies::dissipation`]; zero without energies.
    pub fn dissipation(&self, at: &Motion<'_>) -> f64 {
        self.energies.map_or(0.0, |e| e.dissipation(at))
    }

    /// [`CrossSections::section_states`]; nothing without cross-sections.
    pub fn section_states(&self, at: &Motion<'_>, out: &mut Vec<SectionState>) {
        if let Some(sections) = self.sections {
            sections.section_states(at, out);
        }
    }
}

/// Energies of an element, and its damping.
pub trait ElementEnergies {
    /// Stored (strain or load) energy; zero by default.
    fn energy(&self, at: &Motion<'_>) -> f64 {
        let _ = at;
        0.0
    }

    /// Kinetic energy in motion, if it can be computed faster than ½ ẋ·M ẋ.
    fn kinetic_energy(&self, at: &Motion<'_>) -> Option<f64> {
        let _ = at;
        None
    }

    /// Power lost in damping, ≥ 0; zero by default.
    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        let _ = at;
        0.0
    }
}

/// An element that forms the combined tangent of an integrator faster than its parts K, C and M.
pub trait Combined {
    /// Adds the residual to `r` and w.K·K + w.C·C + w.M·M to each matrix (n×n, column by column) with the
    /// weights w, as [`Element::evaluate`](super::Element::evaluate) does. All are zero on entry.
    ///
    /// # Errors
    /// As [`Element::evaluate`](super::Element::evaluate).
    fn add(
        &self,
        at: &Motion<'_>,
        r: &mut [f64],
        tangents: &mut CombinedTangents<'_>,
    ) -> Result<(), DomainError>;
}

/// State of one cross-section of an element, for output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionState {
    /// Position of the cross-section's centre in the reference configuration, global components.
    pub reference: Vector3<f64>,
    /// Current position, global components.
    pub position: Vector3<f64>,
    /// Current orientation R(Ψ)R₀: section axes e₁, e₂, e₃ as columns, global components.
    pub frame: Matrix3<f64>,
    /// Strains Γ (elongation and two shears), components in the section axes.
    pub Gamma: Vector3<f64>,
    /// Curvatures K (twist and two bendings) per unit length, components in the section axes.
    pub K: Vector3<f64>,
    /// Normal force and two shear forces, those of damping included, components in the section axes.
    pub N: Vector3<f64>,
    /// Torque and two bending moments, likewise.
    pub M: Vector3<f64>,
}

/// Cross-sections of an element.
pub trait CrossSections {
    /// Appends their states.
    fn section_states(&self, at: &Motion<'_>, out: &mut Vec<SectionState>);
}
