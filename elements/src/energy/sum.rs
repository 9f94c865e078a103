//! Sum of two elements on the same nodes.

#![allow(non_snake_case)]

use crate::element::{
    Abilities, Combined, CombinedTangents, CrossSections, Element, ElementEnergies, Motion,
    Properties, Response, SectionState,
};
use pullback_manifold::domain::DomainError;

/// The sum of two elements with the same coordinates, such as a stiffness and an inertia with
/// different integration points. Both read poses or neither does, and at most one enforces equations:
/// the evaluation of other sums is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sum<A, B>(pub A, pub B);

impl<A: Element, B: Element> Sum<A, B> {
    fn both(&self) -> [Abilities<'_>; 2] {
        [self.0.abilities(), self.1.abilities()]
    }
}

impl<A: Element, B: Element> Element for Sum<A, B> {
    fn dim(&self) -> usize {
        self.0.dim()
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let [a, b] = self.both();
        let both_enforce = a.enforced.is_some() && b.enforced.is_some();
        if both_enforce || self.0.properties().reads_poses != self.1.properties().reads_poses {
            return Err(DomainError::Beyond {
                limit: "what a sum can hold, elements that read poses or elements that do not, with one \
                       set of equations: add them to the model one by one",
                margin: 0.0,
            });
        }
        self.0.evaluate(at, out)?;
        self.1.evaluate(at, out)
    }

    fn abilities(&self) -> Abilities<'_> {
        let [a, b] = self.both();
        Abilities {
            combined: a.combined.and(b.combined).is_some().then_some(self),
            energies: a.energies.or(b.energies).is_some().then_some(self),
            enforced: a.enforced.or(b.enforced),
            sections: a.sections.or(b.sections).is_some().then_some(self),
        }
    }

    fn kinks(&self) -> Vec<f64> {
        let mut kinks = self.0.kinks();
        kinks.extend(self.1.kinks());
        kinks
    }

    fn properties(&self) -> Properties {
        self.0.properties().sum(self.1.properties())
    }
}

impl<A: Element, B: Element> Combined for Sum<A, B> {
    fn add(
        &self,
        at: &Motion<'_>,
        r: &mut [f64],
        tangents: &mut CombinedTangents<'_>,
    ) -> Result<(), DomainError> {
        for part in self.both().iter().filter_map(|e| e.combined) {
            part.add(at, r, tangents)?;
        }
        Ok(())
    }
}

impl<A: Element, B: Element> ElementEnergies for Sum<A, B> {
    fn energy(&self, at: &Motion<'_>) -> f64 {
        let [a, b] = self.both();
        a.energy(at) + b.energy(at)
    }

    fn kinetic_energy(&self, at: &Motion<'_>) -> Option<f64> {
        let [a, b] = self.both();
        Some(a.kinetic_energy(at)? + b.kinetic_energy(at)?)
    }

    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        let [a, b] = self.both();
        a.dissipation(at) + b.dissipation(at)
    }
}

impl<A: Element, B: Element> CrossSections for Sum<A, B> {
    fn section_states(&self, at: &Motion<'_>, out: &mut Vec<SectionState>) {
        let [a, b] = self.both();
        a.section_states(at, out);
        b.section_states(at, out);
    }
}
