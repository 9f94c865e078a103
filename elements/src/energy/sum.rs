//! Sum of two elements on the same nodes.

#![allow(non_snake_case)]

use crate::constraint::Enforced;
use crate::element::{
    Combined, CombinedTangents, Element, Motion, Properties, Response, SectionState,
};
use pullback_manifold::domain::DomainError;

/// The sum of two elements with the same coordinates, such as a stiffness and an inertia with
/// different integration points. Both read poses or neither does, and at most one enforces equations:
/// the evaluation of other sums is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sum<A, B>(pub A, pub B);

impl<A: Element, B: Element> Element for Sum<A, B> {
    fn dim(&self) -> usize {
        self.0.dim()
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let both_enforce = self.0.enforced().is_some() && self.1.enforced().is_some();
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

    fn combined(&self) -> Option<&dyn Combined> {
        let both = self.0.combined().is_some() && self.1.combined().is_some();
        both.then_some(self)
    }

    fn enforced(&self) -> Option<&dyn Enforced> {
        self.0.enforced().or_else(|| self.1.enforced())
    }

    fn energy(&self, at: &Motion<'_>) -> f64 {
        self.0.energy(at) + self.1.energy(at)
    }

    fn kinetic_energy(&self, at: &Motion<'_>) -> Option<f64> {
        Some(self.0.kinetic_energy(at)? + self.1.kinetic_energy(at)?)
    }

    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        self.0.dissipation(at) + self.1.dissipation(at)
    }

    fn kinks(&self) -> Vec<f64> {
        let mut kinks = self.0.kinks();
        kinks.extend(self.1.kinks());
        kinks
    }

    fn section_states(&self, at: &Motion<'_>, out: &mut Vec<SectionState>) {
        self.0.section_states(at, out);
        self.1.section_states(at, out);
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
        for part in [self.0.combined(), self.1.combined()].into_iter().flatten() {
            part.add(at, r, tangents)?;
        }
        Ok(())
    }
}
